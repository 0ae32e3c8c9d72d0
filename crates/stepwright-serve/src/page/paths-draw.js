// The way of two motors, or of one over time; its speed or laser power as colour.

import { colour, dark, open, places } from "./colours.js";

/** Margins for the numbers, and around the way, in px. */
const SIDE = 58;
const BELOW = 40;
const AIR = 22;

/** The height of the speed over time, in px. */
const STRIP = 74;

/** Colours, from zero to the most. */
const PACES = ["--pace-0", "--pace-1", "--pace-2", "--pace-3"];

/** Colours of a way, except parts with a gradient. */
const SHADES = 120;

/** The strength of pale colours. */
const PALE = 0.28;

/** A stop of at least this time has a mark, in s. */
const STANDS = 0.05;

const parts = (text) => text.match(/[\d.]+/g).slice(0, 3).map(Number);

/** The colour of a part, 0 to 1, of the most; mixed with the card by `strength`. */
export function ramp(strength = 1) {
  const card = parts(colour("--card"));
  const over = (stop) => stop.map((value, i) => card[i] + (value - card[i]) * strength);
  const stops = PACES.map((name) => over(parts(colour(name))));
  return (part) => {
    const place = Math.min(Math.max(part, 0), 1) * (stops.length - 1);
    const n = Math.min(Math.floor(place), stops.length - 2);
    const mixed = stops[n].map((from, i) => Math.round(from + (stops[n + 1][i] - from) * (place - n)));
    return `rgb(${mixed.join(",")})`;
  };
}

/** Round numbers between two, about `count`. */
export function ticks(from, to, count) {
  const rough = (to - from) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((n) => n * power).find((one) => one >= rough * 0.999);
  const values = [];
  for (let n = Math.ceil(from / step - 1e-9); n * step <= to + step * 1e-9; n++) values.push(n * step);
  return values.map((value) => [value, value.toFixed(places(step)).replace("-", "−")]);
}

export class PathCanvas {
  constructor(canvas, strip) {
    // The grid and the way are on a layer, to which a moving playhead adds.
    const layer = document.createElement("canvas");
    Object.assign(this, { canvas, strip, layer, lies: "", until: 0, count: 0, sheet: null, axes: [0, 1], head: null, leg: null });
    new ResizeObserver(() => this.draw()).observe(canvas.parentElement);
    dark.addEventListener("change", () => this.draw());
  }

  /** Shows a drawing (see `scaled` of paths.js) by these two columns. */
  show(sheet, axes) {
    Object.assign(this, { sheet, axes, count: this.count + 1 });
    this.draw();
  }

  /** Sets the playhead: a time and the motors' places, or nothing. */
  at(head) {
    this.head = head;
    // At most once a frame.
    this.due ??= requestAnimationFrame(() => this.draw());
  }

  /** Highlights these legs, or none. */
  choose(legs) {
    this.leg = legs;
    this.draw();
  }

  /** The values of an axis: a motor's places, or the time. */
  column(axis) {
    return axis < 0 ? this.sheet.times : this.sheet.places[axis];
  }

  /** Maps values to px. */
  frame(width, tall) {
    const [x, y] = this.axes.map((axis) => this.column(axis));
    const range = (values) => values.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
    const spans = [range(x), range(y)].map(([low, high]) => (high > low ? [low, high] : [low - 1, high + 1]));
    const room = [width - SIDE - 2 * AIR, tall - BELOW - 2 * AIR];
    const sizes = spans.map(([low, high], i) => room[i] / (high - low));
    // Both have one scale, unless one is the time.
    const even = this.axes.every((axis) => axis >= 0);
    const scale = even ? [Math.min(...sizes), Math.min(...sizes)] : sizes;
    // A nearly straight way takes only a strip.
    const height = even ? Math.max(Math.min((spans[1][1] - spans[1][0]) * scale[1], room[1]), 130) : room[1];
    const middle = spans.map(([low, high]) => (low + high) / 2);
    const centre = [SIDE + AIR + room[0] / 2, AIR + height / 2];
    return {
      height: height + 2 * AIR + BELOW,
      bottom: height + 2 * AIR,
      x: (value) => centre[0] + (value - middle[0]) * scale[0],
      y: (value) => centre[1] - (value - middle[1]) * scale[1],
      low: [middle[0] - (centre[0] - SIDE) / scale[0], middle[1] - (height / 2 + AIR) / scale[1]],
      high: [middle[0] + (width - centre[0]) / scale[0], middle[1] + (height / 2 + AIR) / scale[1]],
    };
  }

  draw() {
    cancelAnimationFrame(this.due);
    this.due = null;
    const { sheet, canvas, layer } = this;
    const width = canvas.clientWidth;
    if (!sheet || !width) return;
    const tall = Math.min(Math.max(width * 0.78, 320), Math.max(innerHeight * 0.62, 320));
    const colours = Object.fromEntries(["ink", "soft", "line", "card", "accent"].map((name) => [name, colour(`--${name}`)]));
    const until = this.head && !this.head.done ? this.head.time : Infinity;
    const lies = [this.count, this.axes, width, tall, devicePixelRatio, dark.matches, this.leg, until === Infinity].join();
    if (lies !== this.lies || until < this.until) {
      Object.assign(this, { lies, until: -1, framed: this.frame(width, tall) });
      const under = open(layer, width, this.framed.height);
      this.drawGrid(under, width, this.framed, colours);
      this.drawWay(under, this.framed, null);
    }
    this.drawWay(layer.getContext("2d"), this.framed, [this.until, until]);
    this.until = until;
    const pen = open(canvas, width, this.framed.height);
    pen.drawImage(layer, 0, 0, width, this.framed.height);
    this.drawMarks(pen, this.framed, colours);
    this.drawHead(pen, this.framed, colours);
    this.drawStrip(width, colours);
  }

  drawGrid(pen, width, frame, { soft, line, ink }) {
    const { sheet, axes } = this;
    const name = (axis) => (axis < 0 ? "Time, s" : `${sheet.motors[axis]}, ${sheet.unit}`);
    pen.textBaseline = "middle";
    pen.textAlign = "center";
    for (const [value, text] of ticks(frame.low[0], frame.high[0], (width - SIDE) / 80)) {
      const x = Math.round(frame.x(value));
      pen.fillStyle = line;
      pen.fillRect(x, 4, 1, frame.bottom - 4);
      pen.fillStyle = soft;
      if (x > SIDE + 8 && x + pen.measureText(text).width / 2 < width) pen.fillText(text, x, frame.bottom + 11);
    }
    pen.textAlign = "right";
    for (const [value, text] of ticks(frame.low[1], frame.high[1], frame.bottom / 56)) {
      const y = Math.round(frame.y(value));
      pen.fillStyle = line;
      pen.fillRect(SIDE, y, width - SIDE, 1);
      pen.fillStyle = soft;
      if (y > 22) pen.fillText(text, SIDE - 7, y, SIDE - 8);
    }
    pen.fillStyle = ink;
    pen.textAlign = "left";
    pen.fillText(name(axes[1]), 0, 9);
    pen.textAlign = "right";
    pen.fillText(name(axes[0]), width - 2, frame.bottom + 30);
  }

  /** The way between two times in its colours, or all of it in pale ones. Legs not chosen are
   *  always pale, and a laser that is off leaves a thin line. */
  drawWay(pen, frame, times) {
    const { sheet } = this;
    const [x, y] = this.axes.map((axis) => this.column(axis));
    const [from, until] = times ?? [-1, Infinity];
    const paint = ramp(times ? 1 : PALE);
    const at = (i) => [frame.x(x[i]), frame.y(y[i])];
    // A long way has thousands of points; those of one colour are one line.
    let same = null;
    const end = () => (same !== null && pen.stroke(), (same = null));
    pen.lineJoin = "round";
    const draw = (leg, wide) => {
      for (let n = leg.first; n < leg.last; n++) {
        if (sheet.times[n] < from || sheet.times[n] >= until) {
          end();
          continue;
        }
        const [a, b] = [at(n), at(n + 1)];
        const shades = [sheet.shades[n], sheet.shades[n + 1]];
        if (Math.abs(shades[0] - shades[1]) < 1 / SHADES || Math.hypot(b[0] - a[0], b[1] - a[1]) < 4) {
          const off = sheet.powers && Math.max(...shades) === 0;
          const shade = off ? -1 : Math.round(Math.max(...shades) * SHADES);
          if (shade !== same) {
            end();
            pen.lineWidth = off ? 1 : wide;
            pen.strokeStyle = off ? colour("--line") : paint(shade / SHADES);
            pen.beginPath();
            pen.moveTo(...a);
            same = shade;
          }
          pen.lineTo(...b);
          continue;
        }
        end();
        const mixed = pen.createLinearGradient(...a, ...b);
        for (let i = 0; i <= 4; i++) mixed.addColorStop(i / 4, paint(shades[0] + ((shades[1] - shades[0]) * i) / 4));
        pen.lineWidth = wide;
        pen.strokeStyle = mixed;
        pen.beginPath();
        pen.moveTo(...a);
        pen.lineTo(...b);
        pen.stroke();
      }
      end();
    };
    sheet.legs.forEach((leg, n) => {
      const chosen = this.leg?.includes(n);
      if (!times || chosen || !this.leg) draw(leg, chosen ? 5 : 3);
    });
  }

  /** Where the motion begins, stops and ends. */
  drawMarks(pen, frame, { card, ink }) {
    const { sheet } = this;
    const [x, y] = this.axes.map((axis) => this.column(axis));
    const mark = (n, radius, fill) => {
      pen.beginPath();
      pen.arc(frame.x(x[n]), frame.y(y[n]), radius, 0, 7);
      pen.fillStyle = fill;
      pen.fill();
      pen.lineWidth = 2;
      pen.strokeStyle = ink;
      pen.stroke();
    };
    const moving = sheet.legs.filter((leg) => leg.moves);
    if (!moving.length) return;
    const onWay = ({ point }) => moving.some((leg) => point > leg.first && point <= leg.last);
    for (const stand of sheet.stands) if (stand.seconds >= STANDS && onWay(stand)) mark(stand.point, 3.2, card);
    mark(moving[0].first, 6, card);
    mark(moving.at(-1).last, 4.5, ink);
  }

  drawHead(pen, frame, { accent, card }) {
    if (!this.head) return;
    const [x, y] = this.axes.map((axis, i) => frame["xy"[i]](axis < 0 ? this.head.time : this.head.places[axis]));
    pen.beginPath();
    pen.arc(x, y, 9, 0, 7);
    pen.fillStyle = card;
    pen.fill();
    pen.lineWidth = 4;
    pen.strokeStyle = accent;
    pen.stroke();
  }

  /** The same value over time, in the same colours. */
  drawStrip(width, { soft, line, ink }) {
    const { sheet } = this;
    const paint = ramp();
    const pen = open(this.strip, width, STRIP);
    // A slider's knob has half its width at each end.
    const inner = width - 16;
    const x = (time) => 8 + (time / (sheet.seconds || 1)) * inner;
    const y = (shade) => STRIP - 18 - shade * (STRIP - 24);
    pen.textBaseline = "middle";
    pen.textAlign = "center";
    for (const [value, text] of ticks(0, sheet.seconds || 1, width / 90)) {
      pen.fillStyle = line;
      pen.fillRect(Math.round(x(value)), 2, 1, STRIP - 20);
      pen.fillStyle = soft;
      if (x(value) < width - 20) pen.fillText(value ? text : "0 s", Math.max(x(value), 10), STRIP - 8);
    }
    const mixed = pen.createLinearGradient(0, y(0), 0, y(1));
    for (let i = 0; i <= 4; i++) mixed.addColorStop(i / 4, paint(i / 4));
    pen.fillStyle = mixed;
    pen.beginPath();
    pen.moveTo(x(0), y(0));
    sheet.times.forEach((time, n) => pen.lineTo(x(time), y(sheet.shades[n])));
    pen.lineTo(x(sheet.seconds), y(0));
    pen.fill();
    pen.fillStyle = line;
    pen.fillRect(0, y(0), width, 1);
    if (!this.head) return;
    pen.fillStyle = ink;
    pen.fillRect(x(Math.min(this.head.time, sheet.seconds)) - 1, 0, 2, STRIP - 16);
  }
}
