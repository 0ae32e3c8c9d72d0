// The edges of a record of GET /api/scope: when each was, and as files.

import { mcapOf } from "./mcap.js";

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

/** The place of the first time that is not before this one. */
export const firstFrom = (times, time) => first(times.length, (n) => times[n] >= time);

/** A record with times in µs from its beginning. */
export class Edges {
  constructor(record) {
    this.record = record;
    /** µs of a tick. */
    this.tick = 1e6 / record.hz;
    this.length = (record.end - record.begin) * this.tick;
    this.signals = record.signals.map((signal) => {
      let ticks = 0;
      const times = Float64Array.from(signal.edges, (more) => (ticks += more) * this.tick);
      return { ...signal, times };
    });
  }

  /** The level of a pin at a time; null if it is not known. */
  levelAt(signal, time) {
    if (signal.level === null) return null;
    const changes = firstFrom(signal.times, time + this.tick / 2);
    return (changes % 2 === 1) !== signal.level;
  }

  /** Rising edges of a pin between two times. */
  rises(signal, from, to) {
    const [first, last] = [from, to].map((time) => firstFrom(signal.times, time));
    const rising = (n) => (n % 2 === 0) !== signal.level;
    let count = Math.floor((last - first) / 2);
    if ((last - first) % 2 === 1 && rising(first)) count++;
    return count;
  }

  /** Steps of an axis between two times. A motor on coils changes its lines at one moment for each. */
  steps(axis, from, to) {
    const mine = this.signals.filter((one) => one.axis === axis);
    const step = mine.find((one) => one.pin === "step");
    if (step) return this.rises(step, from, to);
    const coils = mine.filter((one) => one.pin === "coil");
    const times = coils.flatMap(({ times }) => [...times.slice(firstFrom(times, from), firstFrom(times, to))]);
    return new Set(times).size;
  }

  /** The edge that is nearest to a time, of all pins; null if there is none. */
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

  /** All edges in order: [ticks, signal, level]. */
  merged() {
    const all = this.record.signals.flatMap((signal, n) => {
      let [ticks, level] = [0, signal.level];
      return signal.edges.map((more) => [(ticks += more), n, (level = !level)]);
    });
    return all.sort((a, b) => a[0] - b[0]);
  }

  /** As a Value Change Dump, in units of 100 ps. */
  vcd() {
    const { record } = this;
    const letter = (n) => String.fromCharCode(33 + n);
    const bit = (level) => (level === null ? "x" : Number(level));
    const unit = 1e10 / record.hz;
    const at = (ticks) => `#${Math.round(ticks * unit)}`;
    const lines = [`$comment ${record.words} $end`, "$timescale 100 ps $end", "$scope module board $end"];
    record.signals.forEach((one, n) => lines.push(`$var wire 1 ${letter(n)} ${one.name} $end`));
    lines.push("$upscope $end", "$enddefinitions $end", "#0", "$dumpvars");
    record.signals.forEach((one, n) => lines.push(`${bit(one.level)}${letter(n)}`));
    lines.push("$end");
    let last = null;
    for (const [ticks, n, level] of this.merged()) {
      if (ticks !== last) lines.push(at((last = ticks)));
      lines.push(`${bit(level)}${letter(n)}`);
    }
    lines.push(at(record.end - record.begin), "");
    return lines.join("\n");
  }

  /** As a table: µs, and every level. */
  csv() {
    const { signals } = this.record;
    const levels = signals.map((one) => one.level);
    const row = (ticks) => [(ticks * this.tick).toFixed(4), ...levels.map((level) => (level === null ? "" : Number(level)))].join();
    const lines = [["time_us", ...signals.map((one) => one.name)].join(), row(0)];
    const edges = this.merged();
    edges.forEach(([ticks, n, level], place) => {
      levels[n] = level;
      if (edges[place + 1]?.[0] !== ticks) lines.push(row(ticks));
    });
    return `${lines.join("\n")}\n`;
  }

  /** As MCAP: the levels at the beginning, and every edge, in ns from there, rounded down. */
  mcap() {
    const { record } = this;
    const nanos = ([ticks, n, level]) => [Math.floor((ticks * 1e9) / record.hz), n, level];
    return mcapOf(record.signals, this.merged().map(nanos), record.words);
  }
}
