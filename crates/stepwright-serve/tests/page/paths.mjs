// The Paths view in a browser: what is drawn against the numbers of the file, what is wrong
// with a file.
//
//   node paths.mjs STEPWRIGHT CHROMIUM [FOLDER]
//
// FOLDER is one for pictures. Ends with 0 if all is as it should be.

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";

import { browser, running, serve, until, watched } from "./common.mjs";

const [folder] = process.argv.slice(4);

async function open(url, options = {}) {
  const size = { viewport: { width: 1440, height: 1000 }, ...options };
  const { context, page, faults } = await watched(`${url}#paths`, size);
  await page.locator("#paths-legs tbody tr").first().waitFor();
  return { context, page, faults };
}

const choose = async (page, name) => {
  await page.locator("#paths-file").selectOption({ label: name });
  await until(`${name} is drawn`, async () => (await page.locator("#paths[aria-busy]").count()) === 0);
};
const rows = (page) => page.locator("#paths-legs tbody tr").allInnerTexts();
const seek = (page, time) => page.locator("#paths-time").fill(String(time));

/** The colours at these places of the two motors, in the file's shown unit: of the way itself, and
 *  beside it. */
const colours = (page, places) =>
  page.evaluate((places) => {
    const { canvas } = document.getElementById("paths").view;
    const frame = canvas.framed;
    const pen = canvas.canvas.getContext("2d");
    const scale = devicePixelRatio;
    const at = (x, y) => [...pen.getImageData(Math.round(x * scale), Math.round(y * scale), 1, 1).data].slice(0, 3);
    return places.map(([x, y]) => at(frame.x(x), frame.y(y)));
  }, places);

const pace = (page, part) =>
  page.evaluate(async (part) => (await import("./paths-draw.js")).ramp()(part).match(/\d+/g).map(Number), part);

const near = (one, other) => one.every((value, i) => Math.abs(value - other[i]) <= 40);

const ONE = `[[motor]]
name = "lift"
step = 1000
smallest-delay-us = 500

[[cycle]]
move.lift = { steps = 2000, delay-us = 1000 }
`;

const tests = {
  async "what is drawn is where the file says, coloured by its speed"(url) {
    const { page, faults, context } = await open(url);
    assert.match(await page.locator("#paths-sum").innerText(), /^12 parts, 8\.2115 s, at most 60 mm\/s$/);
    const all = await rows(page);
    assert.match(all[0], /^1 Homing\s+0, 12\s+0\.97 s\s+–$/);
    assert.match(all[3], /^4 Arc\s+50, 10\s+0\.4142 s\s+60$/);
    assert.match(all[11], /^12 Arc\s+25, 10\s+2\.123 s\s+60$/);
    // On the canvas: the fast middle of a line and the circle's side, a corner where it rests, the
    // arc's own place (45°), and where nothing is: the corner of the square that the arc cuts off.
    const round = 40 + 10 * Math.SQRT1_2;
    const spots = [[25, 0], [10, 25], [50, 40], [round, round], [49.5, 49.5], [25, 25]];
    const [line, side, corner, arc, cut, inside] = await colours(page, spots);
    const [fast, slow] = [await pace(page, 1), await pace(page, 0)];
    assert.ok(near(line, fast), `${line} ${fast}`);
    assert.ok(near(side, fast), `${side} ${fast}`);
    assert.ok(near(arc, fast), `${arc} ${fast}`);
    assert.ok(near(corner, slow), `${corner} ${slow}`);
    assert.deepEqual(cut, inside);
    assert.ok(!near(cut, slow) && !near(cut, fast), `${cut}`);
    // The other way round: the drawing is turned.
    await page.locator("#paths-x").selectOption({ label: "Y" });
    await page.locator("#paths-y").selectOption({ label: "X" });
    assert.match((await rows(page))[3], /^4 Arc\s+10, 50/);
    assert.ok(near((await colours(page, [[0, 25]]))[0], fast));
    assert.deepEqual(faults, []);
    await context.close();
  },

  async "a playhead goes where the time is put"(url) {
    const { page, context } = await open(url);
    const view = (script) => page.evaluate(`(() => { const view = document.getElementById("paths").view; return ${script}; })()`);
    const said = page.locator("#paths-at");
    await seek(page, 1.7);
    // Along the line from 10 to 40 mm, which takes 0.65 s: in its middle.
    const [time, x, y] = await view("[view.canvas.head.time, ...view.canvas.head.places]");
    assert.ok(Math.abs(time - 1.7) < 0.005 && Math.abs(y) < 1e-9, `${time} ${y}`);
    const right = 10 + 60 * (time - (await view("view.sheet.rows[2].begin"))) - 4.5;
    assert.ok(Math.abs(x - right) < 0.1, `${x} ${right}`);
    assert.match(await said.innerText(), /^1\.70 s · X 2\d\.\d+, Y 0\.\d+ mm · 60 mm\/s$/);
    // By keys, and by the table.
    await page.locator("#paths-time").focus();
    await page.keyboard.press("End");
    assert.match(await said.innerText(), /^8\.21 s · X 25\.0+, Y 10\.0+ mm/);
    await page.locator("#paths-legs button").nth(11).click();
    assert.match(await said.innerText(), /^6\.09 s · X 25\.0+, Y 10\.0+ mm/);
    assert.deepEqual(await view("view.canvas.leg"), [12]);
    // The others are pale.
    const [line, side] = await colours(page, [[25, 0], [10, 25]]);
    assert.ok(!near(line, await pace(page, 1)), `${line} ${side}`);
    await context.close();
  },

  async "what is wrong with a file is told, with its line"(url) {
    const { page, faults, context } = await open(url);
    await page.locator("#paths-pick").setInputFiles({ name: "lift.toml", mimeType: "text/plain", buffer: Buffer.from(ONE) });
    await page.locator("#paths-sum").getByText("1 part, 2 s, at most 1 mm/s").waitFor();
    // One motor goes over the time.
    assert.equal(await page.locator("#paths-x").inputValue(), "-1");
    assert.match((await rows(page))[0], /^1 Moves\s+2\s+2 s\s+1$/);
    const text = page.locator("#paths-text");
    await text.fill(ONE.replace("delay-us = 1000", "delay = 1000"));
    await page.locator("#paths-wrong").getByText("lift.toml, line 7: unknown field `delay`").waitFor();
    // A space in the text is one, and what was wrong is right again.
    await text.fill(ONE.replace("delay-us = 1000 }", "delay-us = 2000"));
    await text.focus();
    await page.keyboard.press("Control+End");
    await page.keyboard.press("ArrowLeft");
    for (const key of ["Space", "}"]) await page.keyboard.press(key);
    assert.match(await text.inputValue(), /2000 }\n$/);
    await page.locator("#paths-sum").getByText("1 part, 4 s, at most 0.5 mm/s").waitFor();
    assert.equal(await page.locator("#paths-wrong li").count(), 0);
    // The examples are still there, and so is one's own file.
    await choose(page, "triangle.toml");
    await page.locator("#paths-sum").getByText("4 parts, 78.336 s").waitFor();
    await choose(page, "lift.toml");
    await page.locator("#paths-sum").getByText("1 part").waitFor();
    assert.deepEqual(faults.filter((one) => !one.includes("422")), []);
    await context.close();
  },

  async "on a phone nothing is cut off"(url) {
    const { page, context } = await open(url, { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true });
    for (const name of ["drawing.toml", "series.toml", "calibrate.toml", "triangle.toml"]) {
      await choose(page, name);
      const [wide, room] = await page.evaluate(() => [document.scrollingElement.scrollWidth, innerWidth]);
      assert.ok(wide <= room, `${name}: ${wide} in ${room}`);
    }
    await context.close();
  },
};

/** Light and dark, wide and narrow. */
async function pictures(url) {
  mkdirSync(folder, { recursive: true });
  const sizes = { wide: { viewport: { width: 1440, height: 1000 } }, phone: { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true } };
  for (const [size, options] of Object.entries(sizes)) {
    for (const scheme of ["light", "dark"]) {
      const { page, context } = await open(url, { ...options, colorScheme: scheme });
      await seek(page, 7.9);
      await page.locator("h1").click();
      if (size === "phone") await page.evaluate(() => scrollTo(0, document.querySelector("#paths .right").offsetTop - 110));
      await page.evaluate(() => new Promise((on) => requestAnimationFrame(() => requestAnimationFrame(on))));
      await page.screenshot({ path: join(folder, `paths-${size}-${scheme}.png`) });
      await context.close();
    }
  }
}

let failed = 0;
const { said: url } = await serve("--virtual");
try {
  for (const [name, test] of Object.entries(tests)) {
    try {
      await test(url);
      console.log(`passed: ${name}`);
    } catch (error) {
      failed++;
      console.log(`FAILED: ${name}\n${error.stack}`);
      for (const context of browser.contexts()) await context.close();
    }
  }
  if (folder) await pictures(url);
} finally {
  await browser.close();
  for (const child of running) child.kill("SIGKILL");
}
process.exitCode = failed ? 1 : 0;
