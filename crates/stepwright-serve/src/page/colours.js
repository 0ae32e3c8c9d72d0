// What canvases and charts share; the colours of the page among it, for they know no light-dark().

import { element } from "./dom.js";

/** Changes when the page changes its colours. */
export const dark = matchMedia("(prefers-color-scheme: dark)");

/** Colours by their names, until the page changes its own. */
const known = new Map();
dark.addEventListener("change", () => known.clear());

/** A colour as the page has it now. */
export function colour(name) {
  if (!known.has(name)) {
    const probe = element("i");
    probe.style.color = `var(${name})`;
    document.body.append(probe);
    known.set(name, getComputedStyle(probe).color);
    probe.remove();
  }
  return known.get(name);
}

/** An empty canvas of this size, and its pen. */
export function open(canvas, width, height) {
  const scale = devicePixelRatio || 1;
  canvas.style.height = `${height}px`;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const pen = canvas.getContext("2d");
  pen.scale(scale, scale);
  pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  pen.lineJoin = pen.lineCap = "round";
  return pen;
}

/** With so many places multiples of a step differ. */
export const places = (step) => Math.max(0, -Math.floor(Math.log10(step) + 1e-9));

/** An axis of a chart, as wide as its numbers. */
export function chartAxis(unit = "") {
  const [stroke, grid] = [colour("--soft"), { stroke: colour("--line"), width: 1 }];
  // One place more: a step may be 2.5.
  const values = (_, splits, axis, space, step) => splits.map((value) => Number(value.toFixed(places(step) + 1)) + unit);
  const size = (_, texts) => Math.max(62, ...(texts ?? []).map((text) => 20 + 7 * text.length));
  return { stroke, grid, ticks: grid, values, size };
}

/** The times from and to that were dragged in a chart, if it is more than a click. */
export function dragged(plot) {
  const { left, width } = plot.select;
  if (width < 5) return null;
  plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  return [left, left + width].map((x) => plot.posToVal(x, "x"));
}

/** The same, so faint. */
export const faint = (colour, alpha) => colour.replace("rgb(", "rgba(").replace(")", `, ${alpha})`);
