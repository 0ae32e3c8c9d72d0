// What is known of an axis that is looked at.

/** A speed is measured over this time, in s. */
const WINDOW = 0.1;

export class Watched {
  constructor(axis) {
    this.axis = axis;
    this.position = null;
    this.moving = false;
    this.stop = null;
    /** Whether it runs without end. */
    this.runs = false;
    /** Where its travel began. */
    this.from = null;
    /** The homing that it is on, and what is told of that or of the last one. */
    this.homing = null;
    this.home = null;
    this.origin = 0;
    this.seen = [];
  }

  /** It was seen there at a time in s. */
  see(time, position) {
    this.position = position;
    if (position === null) this.seen = [];
    else this.seen.push([time, position]);
    while (this.seen.length > 1 && time - this.seen[1][0] >= WINDOW) this.seen.shift();
  }

  /** Another place is 0: what was seen before says nothing any more. */
  shiftOrigin() {
    this.seen = [];
    this.origin++;
  }

  /** Its speed in steps/s: the slope of the line through its last places. */
  speed() {
    if (!this.moving || this.seen.length < 2) return 0;
    const count = this.seen.length;
    const mean = (part) => this.seen.reduce((sum, point) => sum + point[part], 0) / count;
    const [time, place] = [mean(0), mean(1)];
    const sum = (term) => this.seen.reduce((all, [t, s]) => all + term(t - time, s - place), 0);
    const below = sum((t) => t * t);
    return below > 0 ? sum((t, s) => t * s) / below : 0;
  }

  /** As GET /api/state has it. */
  state(now) {
    // Between two legs of a homing it is on its way still.
    const moving = this.moving || this.homing !== null;
    const state = this.position === null ? "uncertain" : moving ? "busy" : "ready";
    const { axis, position, stop, home, origin } = this;
    return { axis, position, time: this.seen.at(-1)?.[0] ?? now, speed: this.speed(), moving, state, stop, home, origin };
  }
}
