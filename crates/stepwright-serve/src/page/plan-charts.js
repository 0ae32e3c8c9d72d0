// The curves of several laws in one chart.

import { chartAxis, colour, dark, dragged, faint } from "./colours.js";
import { formatter } from "./dom.js";
import { LAWS } from "./planner.js";

/** Points across a chart. */
const GRID = 1200;

const number = formatter(5);

/** Quantities: name, unit, and whether the range has 0. */
const QUANTITIES = {
  speed: ["Speed", "steps/s", true],
  accel: ["Acceleration", "steps/s²", true],
  position: ["Position", "steps", true],
  interval: ["Interval between steps", "µs", false],
  deviation: ["Delays above those of constant acceleration", "%", true],
};

export class PlanCharts {
  /** Draws into `places`, and the values under the pointer into `values`;
   *  `zoomed(from, to)` gets the dragged times, in s, or nothing. */
  constructor(places, values, zoomed) {
    this.places = places;
    this.values = values;
    this.zoomed = zoomed;
    this.names = ["speed", "accel", "position"];
    this.plans = [];
    this.chosen = 0;
    this.window = [0, 1];
    dark.addEventListener("change", () => this.build());
    new ResizeObserver(() => this.resize()).observe(places[0]);
  }

  /** Shows another quantity in the last chart. */
  third(name) {
    this.names[2] = name;
    this.build();
  }

  /** The plans of the laws, or nothing; the chosen one; the shown time, in s. */
  show(plans, chosen, window) {
    const again = this.window.some((end, i) => end !== window[i]);
    Object.assign(this, { plans, chosen, window });
    if (!this.plots) this.build();
    else this.draw(again);
  }

  width() {
    return Math.max(240, this.places[0].clientWidth);
  }

  height(at) {
    const narrow = innerWidth < 900;
    return [narrow ? 180 : 280, narrow ? 170 : 190, narrow ? 170 : 190][at];
  }

  resize() {
    this.plots?.forEach((plot, at) => plot.setSize({ width: this.width(), height: this.height(at) }));
  }

  build() {
    this.plots?.forEach((plot) => plot.destroy());
    const laws = LAWS.map((_, i) => colour(`--law-${i}`));
    const line = (stroke, width, more) => ({ stroke, width, points: { show: false }, ...more });
    this.plots = this.names.map((name, at) => {
      const [title, unit, zero] = QUANTITIES[name];
      const series = [
        {},
        ...laws.map((colour) => line(colour, 1.5)),
        // The chosen law is on top.
        line(() => laws[this.chosen], 3, {
          fill: name === "speed" ? () => faint(laws[this.chosen], 0.1) : undefined,
        }),
      ];
      const plot = new uPlot(
        {
          width: this.width(),
          height: this.height(at),
          scales: { x: { time: false, range: () => this.window }, y: { range: airy(zero) } },
          axes: [
            { ...chartAxis(" s"), size: 28 },
            chartAxis(),
          ],
          series,
          cursor: { sync: { key: "plan" }, drag: { setScale: false }, points: { show: false } },
          legend: { show: false },
          hooks: {
            drawClear: [(plot) => this.band(plot, faint(colour("--soft"), 0.09))],
            setSelect: [(plot) => this.select(plot)],
            setCursor: [(plot) => this.say(plot, at, unit)],
          },
        },
        [[], ...series.slice(1).map(() => [])],
        this.places[at],
      );
      Object.assign(plot.ctx.canvas, { role: "img", ariaLabel: `${title} over time` });
      plot.over.addEventListener("dblclick", () => this.zoomed());
      return plot;
    });
    this.draw(true);
  }

  select(plot) {
    const ends = dragged(plot);
    if (ends) this.zoomed(...ends);
  }

  /** The value of the chosen law under the pointer. */
  say(plot, at, unit) {
    const place = this.values[at];
    const { idx } = plot.cursor;
    const value = plot.data[LAWS.length + 1]?.[idx];
    place.textContent = value == null ? "" : `${number.format(value)} ${unit} at ${number.format(plot.data[0][idx])} s`;
  }

  /** A tint over the time that the chosen law brakes. */
  band(plot, tint) {
    const figures = this.plans[this.chosen]?.figures;
    if (!figures?.brakingSteps) return;
    const { ctx, bbox } = plot;
    const at = (time) => Math.min(Math.max(plot.valToPos(time, "x", true), bbox.left), bbox.left + bbox.width);
    const [from, to] = [at(figures.seconds - figures.brakingSeconds), at(figures.seconds)];
    ctx.save();
    ctx.fillStyle = tint;
    ctx.fillRect(from, bbox.top, to - from, bbox.height);
    ctx.restore();
  }

  /** Draws the last plans; `moved` if another time is shown. */
  draw(moved) {
    const [from, to] = this.window;
    if (moved || !this.grid) this.grid = Float64Array.from({ length: GRID + 1 }, (_, i) => from + ((to - from) * i) / GRID);
    const times = Array.from(this.grid);
    this.plots.forEach((plot, at) => {
      const lines = LAWS.map((_, law) => {
        const curves = this.plans[law]?.curves;
        return curves ? resampled(curves.time, curves[this.names[at]], this.grid) : [];
      });
      plot.setData([times, ...lines, lines[this.chosen]], true);
    });
  }
}

/** Values between points, at the times of a grid; null beyond the ends. */
function resampled(times, values, grid) {
  const out = new Array(grid.length).fill(null);
  const last = times.length - 1;
  for (let i = 0, at = 0; i < grid.length && last >= 0; i++) {
    const time = grid[i];
    if (time < times[0] || time > times[last]) continue;
    while (at < last - 1 && times[at + 1] < time) at++;
    const [before, behind] = [values[at], values[Math.min(at + 1, last)]];
    const way = times[Math.min(at + 1, last)] - times[at];
    const value = way > 0 ? before + ((behind - before) * (time - times[at])) / way : before;
    if (Number.isFinite(value)) out[i] = value;
    else if (Number.isFinite(behind)) out[i] = behind;
  }
  return out;
}

/** A range with some margin; from 0 if `zero`. */
const airy = (zero) => (_, low, high) => {
  if (low == null || (zero && low === 0 && high === 0)) return [0, 1];
  const [from, to] = zero ? [Math.min(0, low), Math.max(0, high)] : [low, high];
  const air = Math.max((to - from) * 0.06, Math.abs(to) * 0.01);
  return [from < 0 || !zero ? from - air : from, to > 0 || !zero ? to + air : to];
};
