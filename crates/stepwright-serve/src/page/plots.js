// Position, speed and acceleration of all axes on one time line: planned beneath real.

import { chartAxis, colour, dark, dragged, faint } from "./colours.js";
import { Track, planned } from "./curves.js";

/** Kept this long, in s. */
const KEPT = 130;

/** Between two drawings, in ms. */
const DRAW = 33;

const charts = document.getElementById("charts");

const number = new Intl.NumberFormat("en", { maximumFractionDigits: 3, useGrouping: false, signDisplay: "negative" });

export class Plots {
  constructor() {
    this.axes = [];
    this.plots = [];
    this.span = 10;
    this.now = 0;
    this.paused = null;
    this.zoom = null;
    this.drawn = 0;
    charts.plots = this;
    dark.addEventListener("change", () => this.build());
    new ResizeObserver(() => this.resize()).observe(charts);
  }

  /** The axes of a board, as in GET /api/board. */
  describe(sheets) {
    this.axes = sheets.map((sheet) => {
      const known = this.axes.find((axis) => axis.number === sheet.axis);
      const begin = { track: new Track(KEPT), plans: [] };
      return { ...begin, ...known, number: sheet.axis, scale: sheet.steps_per_unit, unit: sheet.unit };
    });
    this.build();
  }

  axis(number) {
    return this.axes.find((axis) => axis.number === number);
  }

  see(state) {
    if (!state.connected) return this.lose();
    // A restarted server counts from 0.
    if (state.time < this.now) this.axes.forEach((axis) => Object.assign(axis, { track: new Track(KEPT), plans: [] }));
    this.now = state.time;
    for (const axis of state.axes) {
      const mine = this.axis(axis.axis);
      if (!mine) continue;
      // Positions from before a new 0 are a line of their own.
      if (axis.position === null || axis.origin !== mine.origin) mine.track.break(state.time);
      mine.origin = axis.origin;
      if (axis.position === null) continue;
      // An axis at rest is where it was seen last.
      mine.track.add(axis.moving ? axis.time : state.time, axis.position, axis.moving);
    }
  }

  /** Without news of the board all lines end, planned and real. */
  lose() {
    for (const { number: axis, track } of this.axes) {
      track.break(this.now);
      this.unplan(axis, this.now);
    }
  }

  plan(curve) {
    const axis = this.axis(curve.axis);
    if (!axis) return;
    this.unplan(curve.axis, curve.begin);
    axis.plans.push(curve);
    while (axis.plans.length > 1 && axis.plans[1].begin < this.now - KEPT) axis.plans.shift();
  }

  unplan(number, time) {
    const plan = this.axis(number)?.plans.at(-1);
    if (plan) plan.until ??= time;
  }

  pause(on) {
    this.paused = on ? this.now : null;
    this.zoom = null;
  }

  /** Makes the charts for the present axes and colours. */
  build() {
    this.plots.forEach((plot) => plot.destroy());
    if (!this.axes.length) return;
    // Each unit has a scale of its own.
    const units = [...new Set(this.axes.map((axis) => axis.unit))];
    const whose = (unit) => (units.length > 1 ? ` (axis ${this.axes.filter((axis) => axis.unit === unit).map((axis) => axis.number).join(", ")})` : "");
    const named = (per) => units.map((unit) => unit + per + whose(unit)).join(", right in ");
    const titles = [`Position in ${named("")}`, `Speed in ${named("/s")}`, `Acceleration in ${named("/s²")}`];
    // Of positions in whole steps the acceleration is the least exact.
    const scales = (at) => units.map((unit) => {
      const least = (at === 2 ? 400 : 5) / Math.max(...this.axes.map((axis) => (axis.unit === unit ? axis.scale : 0)));
      return [unit, { range: comfortable(least, at && units.length > 1) }];
    });
    const time = chartAxis(" s");
    // The values of the three lines at the pointer.
    const show = (unit) => (_, __, line, at) => (at == null ? [] : this.plots).flatMap(({ data }, n) => {
      const value = along(data[0], data[line], at);
      return value == null ? [] : `${number.format(value)} ${unit}${["", "/s", "/s²"][n]}`;
    }).join(", ") || "–";
    const series = this.axes.flatMap(({ number: axis, unit: scale }) => {
      const own = colour(`--axis-${((axis - 1) % 3) + 1}`);
      const pale = faint(own, 0.38);
      const line = { points: { show: false }, value: show(scale), scale };
      return [
        { ...line, label: `${axis} planned`, stroke: pale, width: 6 },
        { ...line, label: `axis ${axis}`, stroke: own, width: 2 },
      ];
    });
    const height = this.height();
    this.plots = titles.map((title, at) => {
      const options = {
        title,
        width: this.width(),
        height,
        class: "chart",
        scales: { x: { time: false, range: () => this.window() }, ...Object.fromEntries(scales(at)) },
        axes: [
          { ...time, size: 30, values: (...all) => time.values(...all).map((text) => (text[0] === "-" ? "" : text)) },
          ...units.map((scale, n) => ({ ...chartAxis(), scale, space: 24, side: n ? 1 : 3, ...(n && { grid: { show: false } }) })),
        ],
        series: [{ label: "time", value: (_, v) => (v === null ? "–" : `${v.toFixed(2)} s`) }, ...series],
        cursor: { sync: { key: "time", setSeries: true }, drag: { setScale: false }, dataIdx: (_, __, at) => at },
        legend: { show: at === 2 },
        hooks: { setSelect: [(plot) => this.select(plot)] },
      };
      const plot = new uPlot(options, [[], ...series.map(() => [])], charts);
      Object.assign(plot.ctx.canvas, { role: "img", ariaLabel: title });
      plot.over.addEventListener("dblclick", () => (this.zoom = null));
      return plot;
    });
    this.draw(true);
  }

  /** The shown time, from and to, in s. */
  window() {
    const end = this.paused ?? this.now;
    return this.zoom ?? [end - this.span, end];
  }

  select(plot) {
    const ends = dragged(plot);
    if (!ends) return;
    this.zoom = ends;
    this.paused ??= this.now;
    this.onpause?.();
    this.draw(true);
  }

  width() {
    return Math.max(240, charts.clientWidth);
  }

  height() {
    return Math.round(Math.min(190, Math.max(120, innerHeight / 5.2)));
  }

  resize() {
    this.plots.forEach((plot) => plot.setSize({ width: this.width(), height: plot.height }));
  }

  /** Draws new points, if it is time. */
  draw(now = false) {
    const time = performance.now();
    if (!this.plots.length || !charts.clientWidth || (!now && time - this.drawn < DRAW)) return;
    if (!now && this.paused !== null) return;
    this.drawn = time;
    const [from, to] = this.window();
    const tables = [[], [], []];
    for (const { track, plans, scale } of this.axes) {
      const ahead = [[], [], [], []];
      for (const plan of plans) {
        // A gap between two plans.
        if (ahead[0].length) ahead.forEach((list, i) => list.push(i ? null : plan.begin - 1e-4));
        planned(plan, to).forEach((list, i) => ahead[i].push(...list));
      }
      const seen = track.columns(from);
      for (const columns of [ahead, seen]) {
        tables.forEach((table, i) => {
          const scaled = columns[i + 1].map((value) => (value ? value / scale : value));
          table.push([columns[0], scaled]);
        });
      }
    }
    // A gap (null) of a line goes up to its next point; times of other lines are none.
    this.plots.forEach((plot, i) => {
      const gaps = tables[i].map(() => [0, 2]);
      plot.setData(uPlot.join(tables[i], gaps), true);
    });
  }
}

/** The value of a line at a time, between the line's own points. */
function along(times, values, at) {
  let [from, to] = [at, at];
  while (values[from] === undefined && from) from--;
  while (values[to] === undefined && to < times.length - 1) to++;
  const part = (times[at] - times[from]) / (times[to] - times[from]) || 0;
  return values[from] == null || values[to] == null ? null : values[from] + (values[to] - values[from]) * part;
}

/** A range with some margin, no narrower than is readable; with 0 in the middle if `even`: so
 *  the zeros of two scales are one line. */
const comfortable = (least, even) => (_, low, high) => {
  if (low == null) return [-1, 1];
  const air = Math.max((high - low) * 0.08, Math.abs(high) * 1e-6, least);
  const far = Math.max(-low, high) + air;
  return even ? [-far, far] : [low - air, high + air];
};
