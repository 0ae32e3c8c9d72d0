// Speeds and accelerations of seen and of planned positions.

/** Half of the time over which speed and acceleration are measured, in s. */
const HALF = 0.12;

/** The points [time, steps, moving] of an axis. */
export class Track {
  constructor(keep) {
    this.keep = keep;
    this.points = [];
  }

  /** Adds a point. Two points are enough for a rest of any length. */
  add(time, steps, moving) {
    const points = this.points;
    const last = points.at(-1);
    if (last && time <= last[0]) return;
    const before = points.at(-2);
    const rests = (point) => point && !point[2] && point[1] === steps;
    if (!moving && rests(last) && rests(before)) {
      last[0] = time;
      return;
    }
    points.push([time, steps, moving]);
    while (points.length > 2 && points[1][0] < time - this.keep) points.shift();
  }

  /** Unknown from here on. */
  break(time) {
    const last = this.points.at(-1);
    // After the last point, which stays.
    if (last && last[1] !== null) this.points.push([Math.max(time, last[0] + 1e-4), null, false]);
  }

  /** Columns of time, position, speed and acceleration from a time on: null is a gap, and
   *  undefined is bridged. */
  columns(from) {
    const points = this.points;
    let begin = points.findIndex((point) => point[0] >= from - 1);
    begin = begin < 0 ? Math.max(0, points.length - 2) : Math.max(0, begin - 1);
    const out = [[], [], [], []];
    for (let i = begin; i < points.length; i++) {
      const [time, steps, moving] = points[i];
      const fitted = steps === null ? [null, null] : fit(points, i, moving);
      [time, steps, ...fitted].forEach((value, column) => out[column].push(value));
    }
    return out;
  }
}

/** Speed and acceleration at a point, from the parabola through its neighbours. */
function fit(points, at, moving) {
  const time = points[at][0];
  let first = at;
  let last = at;
  while (first > 0 && time - points[first - 1][0] <= HALF && points[first - 1][1] !== null) first--;
  while (last + 1 < points.length && points[last + 1][0] - time <= HALF && points[last + 1][1] !== null) last++;
  if (!moving && (first === at || last === at)) return [0, 0];
  // With half the points missing the ends are wild.
  if (last - first < 4 || first === at || points[last][0] - time < HALF / 2) return [undefined, undefined];
  const sums = [0, 0, 0, 0, 0];
  const ways = [0, 0, 0];
  for (let i = first; i <= last; i++) {
    const t = points[i][0] - time;
    const s = points[i][1] - points[at][1];
    for (let power = 0, term = 1; power < 5; power++, term *= t) {
      sums[power] += term;
      if (power < 3) ways[power] += term * s;
    }
  }
  const [c0, c1, c2, c3, c4] = sums;
  const whole = c0 * (c2 * c4 - c3 * c3) - c1 * (c1 * c4 - c2 * c3) + c2 * (c1 * c3 - c2 * c2);
  if (Math.abs(whole) < 1e-18) return [undefined, undefined];
  const [w0, w1, w2] = ways;
  const speed = (c0 * (w1 * c4 - c3 * w2) - w0 * (c1 * c4 - c3 * c2) + c2 * (c1 * w2 - w1 * c2)) / whole;
  const bend = (c0 * (c2 * w2 - w1 * c3) - c1 * (c1 * w2 - w1 * c2) + w0 * (c1 * c3 - c2 * c2)) / whole;
  return [speed, 2 * bend];
}

/** A plan as columns like a track's, up to `now`, or to its end. */
export function planned(curve, now) {
  const out = [[], [], [], []];
  // A gap before the next plan.
  const end = Math.min(now, (curve.until ?? Infinity) - 2e-4) - curve.begin;
  const { seconds, position, speed } = curve;
  const put = (time, at, v, a) => [curve.begin + time, at, v, a].forEach((value, i) => out[i].push(value));
  for (let i = 0; i < seconds.length; i++) {
    const time = seconds[i];
    if (time > end) {
      const part = i ? (end - seconds[i - 1]) / (time - seconds[i - 1]) : 0;
      const between = (list) => list[i - 1] + part * (list[i] - list[i - 1]);
      if (i && part > 0) put(end, between(position), between(speed), slope(curve, i));
      return out;
    }
    put(time, position[i], speed[i], slope(curve, i));
  }
  return out;
}

function slope({ seconds, speed }, i) {
  const before = Math.max(0, i - 1);
  const after = Math.min(seconds.length - 1, i + 1);
  const time = seconds[after] - seconds[before];
  // At its ends a law jumps by its start speed: no acceleration.
  if (before < 1 || after > seconds.length - 2) return null;
  return time > 0 ? (speed[after] - speed[before]) / time : 0;
}
