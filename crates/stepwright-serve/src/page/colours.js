// What canvases and charts share; the colours of the page among it, for they know no light-dark().

import { element } from "./dom.js";

/** Changes when the page changes its colours. */
export const dark = matchMedia("(prefers-color-scheme: dark)");

/** A colour as the page has it now. */
export function colour(name) {
  const probe = element("i");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
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

/** What the axes of charts have in common. */
export function chartAxis() {
  const [stroke, grid] = [colour("--soft"), { stroke: colour("--line"), width: 1 }];
  return { stroke, grid, ticks: grid };
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
