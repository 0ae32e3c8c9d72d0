// Levels of pins over time as an MCAP file, for Foxglove and PlotJuggler: what `GET
// /api/scope.mcap` gives, made here of what is shown.
//
//   magic · header · chunk of schema, channels, messages · an index of each channel's messages ·
//   end of data · summary: schema, channels, statistics, index of the chunk · footer · magic

const MAGIC = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];

/** What a record is. */
const HEADER = 1;
const FOOTER = 2;
const SCHEMA = 3;
const CHANNEL = 4;
const MESSAGE = 5;
const CHUNK = 6;
const MESSAGE_INDEX = 7;
const CHUNK_INDEX = 8;
const STATISTICS = 11;
const DATA_END = 15;

/** The schema of every message; the server's is the same. */
const LEVEL = {
  type: "object",
  properties: { level: { type: "integer", minimum: 0, maximum: 1, description: "1 high, 0 low" } },
};

/** Bytes that grow. Numbers are little-endian; a text, a list and a map have their length in bytes
 *  before them. */
class Bytes {
  constructor() {
    this.view = new DataView(new ArrayBuffer(1 << 16));
    this.length = 0;
  }

  get all() {
    return new Uint8Array(this.view.buffer, 0, this.length);
  }

  /** The place of so many more. */
  room(count) {
    const at = this.length;
    this.length += count;
    if (this.length > this.view.byteLength) {
      const more = new Uint8Array(2 * this.length);
      more.set(new Uint8Array(this.view.buffer, 0, at));
      this.view = new DataView(more.buffer);
    }
    return at;
  }

  u8(number) {
    const at = this.room(1);
    this.view.setUint8(at, number);
  }

  u16(number) {
    const at = this.room(2);
    this.view.setUint16(at, number, true);
  }

  u32(number) {
    const at = this.room(4);
    this.view.setUint32(at, number, true);
  }

  u64(number) {
    const at = this.room(8);
    this.view.setUint32(at, number % 2 ** 32, true);
    this.view.setUint32(at + 4, Math.floor(number / 2 ** 32), true);
  }

  put(bytes) {
    const at = this.room(bytes.length);
    new Uint8Array(this.view.buffer).set(bytes, at);
  }

  text(text) {
    const bytes = new TextEncoder().encode(text);
    this.u32(bytes.length);
    this.put(bytes);
  }

  /** What `write` puts, with its length before it. */
  sized(write, large = false) {
    const at = this.room(large ? 8 : 4);
    const from = this.length;
    write();
    this.view.setUint32(at, this.length - from, true);
  }

  /** A record, and where it begins. */
  record(what, write) {
    const at = this.length;
    this.u8(what);
    this.sized(write, true);
    return at;
  }
}

/** `signals`: names and levels at the beginning; `edges`: [ns, place of the signal, level] in
 *  order of time; `words` say where they are from. */
export function mcapOf(signals, edges, words) {
  const first = signals.flatMap(({ level }, n) => (level === null ? [] : [[0, n, level]]));
  const messages = [...first, ...edges];
  const end = messages.at(-1)?.[0] ?? 0;
  const out = new Bytes();
  const describe = (to) => {
    to.record(SCHEMA, () => {
      to.u16(1);
      to.text("stepwright.Level");
      to.text("jsonschema");
      to.text(JSON.stringify(LEVEL));
    });
    signals.forEach(({ name }, n) => {
      to.record(CHANNEL, () => {
        to.u16(n + 1);
        to.u16(1);
        to.text(`/${name}`);
        to.text("json");
        to.sized(() => ["source", words].forEach((text) => to.text(text)));
      });
    });
  };
  out.put(MAGIC);
  out.record(HEADER, () => ["", "stepwright"].forEach((text) => out.text(text)));

  const records = new Bytes();
  describe(records);
  const index = signals.map(() => []);
  const data = [0, 1].map((level) => new TextEncoder().encode(`{"level":${level}}`));
  for (const [nanos, n, level] of messages) {
    const at = records.record(MESSAGE, () => {
      records.u16(n + 1);
      records.u32(index[n].length);
      records.u64(nanos);
      records.u64(nanos);
      records.put(data[Number(level)]);
    });
    index[n].push([nanos, at]);
  }
  // A sum of 0 is none.
  const chunk = out.record(CHUNK, () => {
    out.u64(0);
    out.u64(end);
    out.u64(records.length);
    out.u32(0);
    out.text("");
    out.u64(records.length);
    out.put(records.all);
  });
  const indexed = out.length;
  const places = index.map((mine, n) => {
    return out.record(MESSAGE_INDEX, () => {
      out.u16(n + 1);
      out.sized(() => mine.flat().forEach((number) => out.u64(number)));
    });
  });
  const behind = out.length;
  out.record(DATA_END, () => out.u32(0));

  const summary = out.length;
  describe(out);
  const byChannel = (numbers) => {
    out.sized(() => numbers.forEach((number, n) => (out.u16(n + 1), out.u64(number))));
  };
  out.record(STATISTICS, () => {
    out.u64(messages.length);
    out.u16(1);
    for (const number of [signals.length, 0, 0, 1]) out.u32(number);
    out.u64(0);
    out.u64(end);
    byChannel(index.map((mine) => mine.length));
  });
  out.record(CHUNK_INDEX, () => {
    for (const number of [0, end, chunk, indexed - chunk]) out.u64(number);
    byChannel(places);
    out.u64(behind - indexed);
    out.text("");
    out.u64(records.length);
    out.u64(records.length);
  });
  out.record(FOOTER, () => {
    out.u64(summary);
    out.u64(0);
    out.u32(0);
  });
  out.put(MAGIC);
  return out.all;
}
