// Shared by canvases and charts, with the page's colours, as they know no light-dark().

import { element } from "./dom.js";

/** Changes when the page changes its colours. */
export const dark = matchMedia("(prefers-color-scheme: dark)");

/** Colours by name, until the page changes them. */
const known = new Map();
dark.addEventListener("change", () => known.clear());

/** A colour of the page now. */
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

/** An empty canvas of this size: its context. */
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

/** Decimals that tell multiples of a step apart. */
export const places = (step) => Math.max(0, -Math.floor(Math.log10(step) + 1e-9));

/** An axis of a chart, as wide as its numbers. */
export function chartAxis(unit = "") {
  const [stroke, grid] = [colour("--soft"), { stroke: colour("--line"), width: 1 }];
  // One more: a step may be 2.5.
  const values = (_, splits, axis, space, step) => splits.map((value) => Number(value.toFixed(places(step) + 1)) + unit);
  const size = (_, texts) => Math.max(62, ...(texts ?? []).map((text) => 20 + 7 * text.length));
  return { stroke, grid, ticks: grid, values, size };
}

/** The times between which a chart was dragged, if it was more than a click. */
export function dragged(plot) {
  const { left, width } = plot.select;
  if (width < 5) return null;
  plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  return [left, left + width].map((x) => plot.posToVal(x, "x"));
}

/** A faint colour. */
export const faint = (colour, alpha) => colour.replace("rgb(", "rgba(").replace(")", `, ${alpha})`);
