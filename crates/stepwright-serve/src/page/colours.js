// The colours of the page for a canvas, which knows no light-dark().

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

/** The same, so faint. */
export const faint = (colour, alpha) => colour.replace("rgb(", "rgba(").replace(")", `, ${alpha})`);
