// The scope: STEP and DIR, or coils, and enable of the last seconds, with two cursors.

import { colour, dark, open, places } from "./colours.js";
import { by, save } from "./dom.js";
import { Edges, firstFrom } from "./edges.js";
import { fileOf, get } from "./server.js";

/** Between two records, in ms. */
const AGAIN = 400;
/** Heights of a lane, of the time scale above, and the names' width, in px. */
const LANE = 34;
const HIGH = 96;
const TOP = 26;
const NAMES = 64;
/** A cursor snaps to an edge this near, in px. */
const NEAR = 8;

/** A readable time from µs, to the tick. */
function shown(us) {
  const size = Math.abs(us);
  const [value, unit] = size >= 1e6 ? [us / 1e6, "s"] : size >= 1e4 ? [us / 1e3, "ms"] : [us, "µs"];
  const digits = unit === "s" ? 6 : unit === "ms" ? 3 : 2;
  return `${value.toFixed(digits)} ${unit}`;
}

export class Scope {
  constructor(tell) {
    this.tell = tell;
    this.edges = null;
    this.held = false;
    this.window = null;
    this.cursors = [null, null];
    this.next = 0;
    this.canvas = by("scope-lanes");
    by("scope-span").onchange = () => this.live();
    by("scope-hold").onclick = () => (this.held ? this.live() : this.hold());
    by("scope-in").onclick = () => this.zoom(0.5);
    by("scope-out").onclick = () => this.zoom(2);
    by("scope-fit").onclick = () => this.fit();
    for (const as of ["vcd", "csv", "mcap"]) by(`scope-${as}`).onclick = () => this.save(as);
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas.parentElement);
    dark.addEventListener("change", () => this.draw());
    setInterval(() => this.look(), AGAIN);
  }

  /** Fetches the last seconds for an open view. */
  async look() {
    if (this.held || this.asking || document.hidden || !this.canvas.clientWidth) return;
    this.asking = true;
    try {
      const record = await get(`/api/scope?seconds=${by("scope-span").value}`);
      if (this.held) return;
      this.edges = new Edges(record);
      this.window = [0, this.edges.length];
      const note = by("scope-source");
      if (note.textContent !== record.words) note.textContent = record.words;
      note.classList.toggle("planned", record.source === "plan");
      this.draw();
    } catch (error) {
      // Without a server it waits for one.
      if (!error.status) return;
      this.hold();
      this.tell(error);
    } finally {
      this.asking = false;
    }
  }

  hold(on = true) {
    this.held = on;
    Object.assign(by("scope-hold"), { ariaPressed: on, textContent: on ? "Go on" : "Hold" });
  }

  live() {
    this.hold(false);
    this.cursors = [null, null];
    this.look();
  }

  fit() {
    if (this.edges) this.show(0, this.edges.length);
  }

  /** Zooms by a factor around a time. */
  zoom(factor, around = null) {
    if (!this.edges) return;
    this.hold();
    const [from, to] = this.window;
    const middle = around ?? this.middle();
    const least = 8 * this.edges.tick;
    const length = Math.min(this.edges.length, Math.max(least, (to - from) * factor));
    const begin = middle - (length * (middle - from)) / (to - from);
    this.show(begin, length);
  }

  /** The middle of the visible cursors, or else of the window. */
  middle() {
    const [from, to] = this.window;
    const seen = this.cursors.filter((time) => time !== null && time >= from && time <= to);
    return seen.length ? seen.reduce((sum, time) => sum + time, 0) / seen.length : (from + to) / 2;
  }

  show(begin, length) {
    const from = Math.max(0, Math.min(this.edges.length - length, begin));
    this.window = [from, from + length];
    this.draw();
  }

  pan(part) {
    if (!this.edges) return;
    this.hold();
    const [from, to] = this.window;
    this.show(from + part * (to - from), to - from);
  }

  timeAt(x) {
    const [from, to] = this.window;
    return from + ((x - NAMES) / (this.canvas.clientWidth - NAMES)) * (to - from);
  }

  xOf(time) {
    const [from, to] = this.window;
    return NAMES + ((time - from) / (to - from)) * (this.canvas.clientWidth - NAMES);
  }

  /** Puts a cursor here, or on a near edge. */
  put(n, x) {
    const [from, to] = this.window;
    const time = Math.max(from, Math.min(to, this.timeAt(x)));
    const edge = this.edges.nearest(time);
    const near = edge !== null && Math.abs(this.xOf(edge) - this.xOf(time)) <= NEAR;
    this.cursors[n] = near ? edge : time;
    this.hold();
    this.draw();
  }

  listen() {
    const { canvas } = this;
    let drag = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !this.edges) return;
      canvas.setPointerCapture(event.pointerId);
      const x = event.offsetX;
      const near = this.cursors.findIndex((time) => time !== null && Math.abs(this.xOf(time) - x) <= NEAR);
      drag = { x, from: this.window[0], cursor: near, moved: false };
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!drag) return;
      if (Math.abs(event.offsetX - drag.x) > 3) drag.moved = true;
      if (!drag.moved) return;
      if (drag.cursor >= 0) {
        this.put(drag.cursor, event.offsetX);
        return;
      }
      this.hold();
      const [from, to] = this.window;
      const length = to - from;
      this.show(drag.from - ((event.offsetX - drag.x) / (canvas.clientWidth - NAMES)) * length, length);
    });
    canvas.addEventListener("pointerup", (event) => {
      if (drag && !drag.moved) {
        this.put(this.next, event.offsetX);
        this.next = 1 - this.next;
      }
      drag = null;
    });
    canvas.addEventListener("pointercancel", () => (drag = null));
    canvas.addEventListener("wheel", (event) => {
      if (!this.edges) return;
      event.preventDefault();
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) this.pan((event.deltaX || event.deltaY) / 1000);
      else this.zoom(1.0015 ** event.deltaY, this.timeAt(event.offsetX));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const middle = (NAMES + canvas.clientWidth) / 2;
      const act = {
        a: () => this.put(0, middle),
        b: () => this.put(1, middle),
        arrowleft: () => this.pan(-0.1),
        arrowright: () => this.pan(0.1),
        "+": () => this.zoom(0.5),
        "-": () => this.zoom(2),
        0: () => this.fit(),
      }[event.key.toLowerCase()];
      if (!act || !this.edges) return;
      event.preventDefault();
      act();
    });
  }

  save(as) {
    if (!this.edges) return;
    this.hold();
    fileOf(as, this.edges.record).then((bytes) => save(`stepwright.${as}`, bytes, "application/octet-stream"), this.tell);
  }

  draw() {
    const { canvas, edges } = this;
    const width = canvas.clientWidth;
    if (!edges || !width) return;
    this.lane = this.laneHeight();
    const height = TOP + this.lane * edges.signals.length + 6;
    const pen = open(canvas, width, height);
    const colours = { ink: colour("--ink"), soft: colour("--soft"), line: colour("--line"), accent: colour("--accent") };
    this.drawTimes(pen, width, height, colours);
    edges.signals.forEach((signal, n) => {
      const own = signal.axis ? colour(`--axis-${((signal.axis - 1) % 3) + 1}`) : colours.ink;
      this.drawLane(pen, signal, TOP + n * this.lane, width, own, colours);
    });
    this.drawCursors(pen, height, colours);
    this.tellCursors();
  }

  /** So high that the lanes fill the room between the elements above and below. */
  laneHeight() {
    const above = this.canvas.getBoundingClientRect().top + scrollY;
    const below = by("scope-cursors").offsetHeight + document.querySelector("footer").offsetHeight + 40;
    const room = (innerHeight - above - below - TOP) / this.edges.signals.length;
    return Math.round(Math.min(HIGH, Math.max(LANE, room)));
  }

  drawTimes(pen, width, height, { soft, line }) {
    const [from, to] = this.window;
    const rough = (to - from) / Math.max(2, (width - NAMES) / 110);
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((n) => n * power).find((one) => one >= rough);
    const [size, unit] = step >= 1e5 ? [1e6, "s"] : step >= 100 ? [1e3, "ms"] : [1, "µs"];
    pen.textBaseline = "middle";
    pen.textAlign = "center";
    for (let n = Math.ceil(from / step); n * step <= to; n++) {
      const x = this.xOf(n * step);
      pen.fillStyle = line;
      pen.fillRect(Math.round(x), TOP - 6, 1, height - TOP);
      pen.fillStyle = soft;
      const text = `${((n * step) / size).toFixed(places(step / size))} ${unit}`;
      const half = pen.measureText(text).width / 2;
      // A time would be under the name of a cursor.
      const free = this.cursors.every((time) => time === null || Math.abs(this.xOf(time) - x) > half + 16);
      if (free && x - half > 0 && x + half < width) pen.fillText(text, x, TOP / 2 - 2);
    }
  }

  drawLane(pen, signal, top, width, own, { soft, line }) {
    const [from, to] = this.window;
    const [high, low] = [top + 7.5, top + this.lane - 6.5];
    pen.fillStyle = own;
    pen.textAlign = "left";
    pen.fillText(signal.name, 4, (high + low) / 2);
    pen.fillStyle = line;
    pen.fillRect(0, top + this.lane, width, 1);
    const { times } = signal;
    if (signal.level === null) {
      pen.fillStyle = soft;
      pen.fillText("not known", NAMES + 8, (high + low) / 2);
      return;
    }
    const first = firstFrom(times, from);
    const last = firstFrom(times, to);
    let level = (first % 2 === 1) !== signal.level;
    pen.strokeStyle = own;
    pen.lineWidth = 1.5;
    pen.beginPath();
    let y = level ? high : low;
    pen.moveTo(NAMES, y);
    let column = -1;
    for (let n = first; n < last; n++) {
      const x = this.xOf(times[n]);
      level = !level;
      const next = level ? high : low;
      // Of many edges in a column one is drawn.
      if (Math.floor(x) !== column) {
        pen.lineTo(x, y);
        pen.lineTo(x, next);
        column = Math.floor(x);
      } else {
        pen.moveTo(x, next);
      }
      y = next;
    }
    pen.lineTo(width, y);
    pen.stroke();
  }

  drawCursors(pen, height, { ink, accent }) {
    this.cursors.forEach((time, n) => {
      if (time === null) return;
      const x = this.xOf(time);
      if (x < NAMES) return;
      pen.fillStyle = n ? ink : accent;
      pen.fillRect(x - 0.75, TOP - 8, 1.5, height);
      // Two near cursors have their names on their outer sides.
      const other = this.cursors[1 - n];
      const left = n ? time < other : time <= other;
      pen.textAlign = other === null || Math.abs(this.xOf(other) - x) > 12 ? "center" : left ? "right" : "left";
      pen.fillText("AB"[n], x, TOP - 14);
    });
  }

  /** Times and counts of the cursors. */
  tellCursors() {
    const [a, b] = this.cursors;
    const parts = [];
    if (a !== null) parts.push(`A ${shown(a)}`);
    if (b !== null) parts.push(`B ${shown(b)}`);
    if (a !== null && b !== null) {
      const between = Math.abs(b - a);
      parts.push(`between ${shown(between)}`);
      if (between > 0) parts.push(`${(1e6 / between).toFixed(2)} Hz`);
      const axes = [...new Set(this.edges.signals.flatMap(({ axis }) => axis ?? []))];
      const counts = axes.map((axis) => [axis, this.edges.steps(axis, Math.min(a, b), Math.max(a, b))]);
      parts.push(`steps of ${counts.map(([axis, count]) => `axis ${axis}: ${count}`).join(", ")}`);
      for (const [axis, count] of counts) {
        if (count && between > 0) parts.push(`axis ${axis} at ${((1e6 * count) / between).toFixed(1)} steps/s`);
      }
    }
    by("scope-cursors").textContent = parts.length ? parts.join(" · ") : "Click twice, or press A and B: cursors, which go to the next edge.";
  }
}
