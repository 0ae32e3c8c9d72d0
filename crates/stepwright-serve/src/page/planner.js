// The planner: the core's ramp laws as WebAssembly, behind typed arrays.
//
// Nothing here needs a page: Node runs it too.

/** The laws, in the order of their numbers; the names are the command's. */
export const LAWS = ["trapezoid", "s-curve", "austin", "austin-fixed", "linear-factor", "power", "piecewise"];

/** The numbers of a travel, in order. */
export const NUMBERS = [
  "rate", "steps", "start", "top", "accel", "decel", "jerk", "c0", "divisor", "knee", "power", "breaks", "from", "to",
];

/** The curves, in order. */
const COLUMNS = ["time", "position", "speed", "accel", "interval", "deviation"];

/** The figures of a plan, in order. */
const FIGURES = [
  "pulses", "ticks", "seconds", "peak", "brakingSteps", "brakingSeconds", "error", "errorStep", "deviation",
  "deviationStep", "deviationRms", "lost", "first", "shortest", "points",
];

export class Planner {
  /** From the module's bytes. */
  static async open(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Planner(instance.exports);
  }

  constructor(door) {
    this.door = door;
    const { buffer } = door.memory;
    const floats = (at, count) => new Float64Array(buffer, at, count);
    this.numbers = floats(door.stepwright_numbers(), door.stepwright_fields());
    this.figures = floats(door.stepwright_figures(), FIGURES.length);
    this.room = door.stepwright_most_points();
    this.columns = floats(door.stepwright_columns(), this.room * COLUMNS.length);
    this.first = this.numbers.slice();
  }

  /** Numbers that can be planned. */
  example() {
    return this.first.slice();
  }

  /** The range of a number, by its place, with both ends. */
  range(at) {
    return [this.door.stepwright_low(at), this.door.stepwright_high(at)];
  }

  /** Plans by a law: figures by name, a hash, and curves; or the refusal. */
  plan(law, numbers) {
    this.numbers.set(numbers);
    if (this.door.stepwright_plan(law)) {
      const { stepwright_what, stepwright_remedy } = this.door;
      return { refused: { what: this.text(stepwright_what()), remedy: this.text(stepwright_remedy()) } };
    }
    const figures = Object.fromEntries(FIGURES.map((name, i) => [name, this.figures[i]]));
    const curves = Object.fromEntries(
      COLUMNS.map((name, i) => [name, this.columns.slice(i * this.room, i * this.room + figures.points)]),
    );
    return { figures, curves, hash: BigInt.asUintN(64, this.door.stepwright_hash()) };
  }

  text(at) {
    const bytes = new Uint8Array(this.door.memory.buffer, at);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }
}
