// The host's half of the line, as WebAssembly: lines to bytes, bytes to answers, and the words of
// the protocol. There is no grammar here.
//
// Nothing here knows a page: Node runs it as well.

/** What has come of a byte, by its number. */
const KINDS = [null, "yes", "no", "ready", "busy", "position", "info", "settings"];

/** The numbers of the answer to `?`; the letters of stops follow. */
const INFO = ["major", "minor", "axes", "max", "late", "refused", "last", "uncertain", "errors", "can"];

const LISTS = ["setting", "unit", "help", "stopLetter", "stop", "stopWords", "error", "errorWords", "ability", "refusal", "refusalName"];

/** The numbers of an order, in their order. */
export const ORDER = ["axis", "steps", "endless", "top_speed", "start_speed", "accel", "decel", "jerk"];

const UNITS = ["", "steps", "", "steps/s", "steps/s", "steps/s²", "steps/s²", "steps/s³"];

export class Host {
  static async open(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Host(instance.exports);
  }

  constructor(door) {
    this.door = door;
    const { buffer } = door.memory;
    this.in = new Uint8Array(buffer, door.stepwright_in(), 64);
    this.out = new Uint8Array(buffer, door.stepwright_out());
    this.answer = new Float64Array(buffer, door.stepwright_answer(), 32);
    this.numbers = new Float64Array(buffer, door.stepwright_order(), ORDER.length);
    this.words = Object.fromEntries(LISTS.map((name, list) => [name, this.list(list)]));
    this.settings = this.words.setting.map((name, at) => {
      const [normal, min, max] = [0, 1, 2].map((which) => door.stepwright_setting(at, which));
      return { name, default: normal, min, max, unit: this.words.unit[at], help: this.words.help[at] };
    });
  }

  list(list) {
    const words = [];
    for (;;) {
      const length = this.door.stepwright_word(list, words.length);
      if (length < 0) return words;
      words.push(this.text(length));
    }
  }

  text(length) {
    return new TextDecoder().decode(this.out.slice(0, length));
  }

  put(line) {
    return this.in.length >= line.length ? new TextEncoder().encodeInto(line, this.in).written : 0;
  }

  /** From now on lines have checksums, or none. */
  useSums(on) {
    this.door.stepwright_sums(on ? 1 : 0);
  }

  /** The bytes of a line; null if it is none of the protocol. */
  say(line) {
    const count = this.door.stepwright_say(this.put(line));
    return count ? this.out.slice(0, count) : null;
  }

  /** The bytes that get in step with a board that was silent. */
  resync() {
    return this.out.slice(0, this.door.stepwright_resync());
  }

  /** A byte of the board; the answer, if it is whole. */
  hear(byte) {
    const kind = KINDS[this.door.stepwright_hear(byte)];
    if (!kind) return null;
    if (kind === "position") return { kind, position: this.answer[0] };
    if (kind === "info") return { kind, info: this.info() };
    if (kind === "settings") return { kind, values: Array.from(this.answer.slice(0, this.settings.length)) };
    return { kind };
  }

  info() {
    const info = Object.fromEntries(INFO.map((name, at) => [name, this.answer[at]]));
    const set = (bits, names) => (bits < 0 ? null : names.filter((_, bit) => (bits >> bit) % 2 === 1));
    const stops = this.answer.slice(INFO.length, INFO.length + info.axes);
    return {
      ...info,
      last: info.last < 0 ? null : this.words.refusal[info.last],
      refusal: info.last < 0 ? null : this.words.refusalName[info.last],
      can: set(info.can, this.words.ability),
      errors: (set(info.errors, this.words.error) ?? []).map((name) => {
        return { name, words: this.words.errorWords[this.words.error.indexOf(name)] };
      }),
      stops: Array.from(stops, (letter) => {
        if (!letter) return null;
        const at = this.words.stopLetter.indexOf(String.fromCharCode(letter));
        return { name: this.words.stop[at], words: this.words.stopWords[at] };
      }),
    };
  }

  /** What a line means. */
  meaning(line) {
    return this.text(this.door.stepwright_meaning(this.put(line)));
  }

  /** What is allowed of a number of an order, by its name: both ends included. */
  range(name) {
    const at = ORDER.indexOf(name);
    return [this.door.stepwright_low(at), this.door.stepwright_high(at), UNITS[at]];
  }

  /** The lines of an order; or the name of the number that is outside its range. */
  script(order) {
    this.numbers.set(ORDER.map((name) => order[name] ?? 0));
    const count = this.door.stepwright_script();
    if (count < 0) return { wrong: ORDER[-1 - count] };
    return { lines: this.text(count).split("\r").slice(0, -1) };
  }
}
