// The virtual board as WebAssembly: bytes of its serial line in, bytes out, and its edges.
//
// Nothing here needs a page: Node runs it too.

/** The pin of an edge, by bits 1 and 2 of its code. */
const PINS = ["step", "dir", "enable"];

export class VirtualBoard {
  /** Switches a board on, from the module's bytes. */
  static async open(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new VirtualBoard(instance.exports);
  }

  constructor(door) {
    this.door = door;
    door.stepwright_on();
    this.hz = door.stepwright_hz();
    this.axes = door.stepwright_axes();
    this.byteTime = door.stepwright_byte_time();
    const { buffer } = door.memory;
    this.kept = door.stepwright_edges_kept();
    this.times = new Float64Array(buffer, door.stepwright_edge_times(), this.kept);
    this.pins = new Uint8Array(buffer, door.stepwright_edge_pins(), this.kept);
    this.out = new Uint8Array(buffer, door.stepwright_out());
  }

  /** Ticks since it was switched on. */
  now() {
    return this.door.stepwright_now();
  }

  busy() {
    return this.door.stepwright_busy() === 1;
  }

  /** Lets time pass until this tick. */
  run(until) {
    this.door.stepwright_run(until);
  }

  /** Receives a byte now; returns the answer. */
  receive(byte) {
    return this.out.slice(0, this.door.stepwright_receive(byte));
  }

  /** The steps of each axis, counted at its pins. */
  shafts() {
    return Array.from({ length: this.axes }, (_, axis) => this.door.stepwright_shaft(axis));
  }

  /** The kept edges, in order of time: [ticks, axis from 0, pin, level]. */
  edges() {
    const count = this.door.stepwright_edges();
    const first = Math.max(0, count - this.kept);
    const edges = Array.from({ length: count - first }, (_, n) => {
      const at = (first + n) % this.kept;
      const code = this.pins[at];
      return [this.times[at], code >> 3, PINS[(code >> 1) & 3], code % 2 === 1];
    });
    // The enable pin is sampled a little later than the others.
    return edges.sort((a, b) => a[0] - b[0]);
  }

  /** The last seconds, as in GET /api/scope. */
  record(seconds) {
    const edges = this.edges();
    const end = this.now();
    const whole = this.door.stepwright_edges() <= this.kept;
    const begin = Math.max(whole ? 0 : edges[0][0], Math.floor(end - seconds * this.hz));
    const names = Array.from({ length: this.axes }, (_, axis) => [[axis, "step"], [axis, "dir"]]).flat();
    const signals = [...names, [0, "enable"]].map(([axis, pin]) => {
      const mine = edges.filter((edge) => edge[1] === axis && edge[2] === pin);
      const first = mine.findIndex((edge) => edge[0] >= begin);
      const [before, after] = first < 0 ? [mine, []] : [mine.slice(0, first), mine.slice(first)];
      let level = before.at(-1)?.[3] ?? (after.length ? !after[0][3] : pin === "step" ? false : null);
      let last = begin;
      const own = { name: pin === "enable" ? pin : `${pin}${axis + 1}`, axis: pin === "enable" ? null : axis + 1, pin, level, edges: [] };
      for (const [time, , , now] of after) {
        if (now === level) continue;
        own.edges.push(time - last);
        [last, level] = [time, now];
      }
      return own;
    });
    return { source: "pins", words: "the edges of the virtual board's pins", hz: this.hz, begin, end, signals };
  }
}
