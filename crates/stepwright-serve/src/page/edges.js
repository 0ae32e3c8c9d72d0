// The edges of a record of GET /api/scope, with times.

/** The first of `count` for which `late(n)` holds. */
export function first(count, late) {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (late(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The place of the first time at or after this one. */
export const firstFrom = (times, time) => first(times.length, (n) => times[n] >= time);

/** A record with times in µs from its beginning. */
export class Edges {
  constructor(record) {
    this.record = record;
    /** µs per tick. */
    this.tick = 1e6 / record.hz;
    this.length = (record.end - record.begin) * this.tick;
    this.signals = record.signals.map((signal) => {
      let ticks = 0;
      const times = Float64Array.from(signal.edges, (more) => (ticks += more) * this.tick);
      return { ...signal, times };
    });
  }

  /** Rising edges of a pin between two times. */
  rises(signal, from, to) {
    const [first, last] = [from, to].map((time) => firstFrom(signal.times, time));
    const rising = (n) => (n % 2 === 0) !== signal.level;
    let count = Math.floor((last - first) / 2);
    if ((last - first) % 2 === 1 && rising(first)) count++;
    return count;
  }

  /** Steps of an axis between two times. A step of a coil motor changes its lines at once. */
  steps(axis, from, to) {
    const mine = this.signals.filter((one) => one.axis === axis);
    const step = mine.find((one) => one.pin === "step");
    if (step) return this.rises(step, from, to);
    const coils = mine.filter((one) => one.pin === "coil");
    const times = coils.flatMap(({ times }) => [...times.slice(firstFrom(times, from), firstFrom(times, to))]);
    return new Set(times).size;
  }

  /** The edge of any pin nearest to a time; null if there is none. */
  nearest(time) {
    let best = null;
    for (const { times } of this.signals) {
      const place = firstFrom(times, time);
      for (const edge of [times[place - 1], times[place]]) {
        if (edge !== undefined && (best === null || Math.abs(edge - time) < Math.abs(best - time))) best = edge;
      }
    }
    return best;
  }
}
