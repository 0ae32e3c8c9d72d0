// Shared by tests of the Paths view: what is drawn, and what is shown about it.

import { until, watched } from "./common.mjs";

/** The Paths view, with a drawing. */
export async function open(url, options = {}) {
  const size = { viewport: { width: 1440, height: 1000 }, ...options };
  const { context, page, faults } = await watched(`${url}#paths`, size);
  await page.locator("#paths-legs tbody tr").first().waitFor();
  return { context, page, faults };
}

/** The parts of the file. */
export const rows = (page) => page.locator("#paths-legs tbody tr").allInnerTexts();
/** Sets the playhead to a time. */
export const seek = (page, time) => page.locator("#paths-time").fill(String(time));

/** The colours at these places of the two motors, in the file's shown unit: of the way itself, and
 *  beside it. */
export const colours = (page, places) =>
  page.evaluate(async (places) => {
    // Changes are drawn with the next frame.
    await new Promise((on) => requestAnimationFrame(() => requestAnimationFrame(on)));
    const { canvas } = document.getElementById("paths").view;
    const frame = canvas.framed;
    const pen = canvas.canvas.getContext("2d");
    const scale = devicePixelRatio;
    const at = (x, y) => [...pen.getImageData(Math.round(x * scale), Math.round(y * scale), 1, 1).data].slice(0, 3);
    return places.map(([x, y]) => at(frame.x(x), frame.y(y)));
  }, places);

/** The colour of this part of the highest speed. */
export const pace = (page, part) =>
  page.evaluate(async (part) => (await import("./paths-draw.js")).ramp()(part).match(/\d+/g).map(Number), part);

/** Whether two colours are alike. */
export const near = (one, other) => one.every((value, i) => Math.abs(value - other[i]) <= 40);

/** The playhead. */
export const head = (page) => page.evaluate(() => document.getElementById("paths").view.canvas.head);
/** The progress of a run, by the server. */
export const report = async (url) => (await fetch(`${url}api/path`)).json();
/** Waits until a run has ended in this state. */
export const ends = (page, state) => until(state, async () => (await page.locator(`#paths-state.${state}`).count()) === 1);
