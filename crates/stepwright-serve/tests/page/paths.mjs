// The Paths view in a browser: the drawing against the numbers of the file, mistakes in a file, and
// a run that is followed and stopped.
//
//   node paths.mjs STEPWRIGHT CHROMIUM STATIC [FOLDER]
//
// STATIC is the folder of the page for any host, FOLDER one for pictures. Ends with 0 if all tests pass.

import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";

import { browser, host, running, serve, until } from "./common.mjs";
import { colours, ends, head, near, open, pace, report, rows, seek } from "./way.mjs";

const [files, folder] = process.argv.slice(4);

const choose = async (page, name) => {
  await page.locator("#paths-file").selectOption({ label: name });
  await until(`${name} is drawn`, async () => (await page.locator("#paths[aria-busy]").count()) === 0);
};

const ONE = `[[motor]]
name = "lift"
step = 1000
smallest-delay-us = 500

[[cycle]]
move.lift = { steps = 2000, delay-us = 1000 }
`;

/** 40 mm across and 30 mm up at 20 mm/s, after a ramp of 0.1 s: 2.6 s. */
const SLANT = `${["X", "Y"].map((name) => `[[motor]]\nname = "${name}"\nstep = 12_500\nsmallest-delay-us = 50\n`).join("\n")}
[[cycle]]
line = { to = { X = 40_000_000, Y = 30_000_000 }, speed = 20_000_000, accel = 200_000_000 }
`;

/** The same at 2 mm/s: 25 s, which no test waits for. */
const SLOW = SLANT.replace("20_000_000,", "2_000_000,");

const slant = async (page, text, sum) => {
  await page.locator("#paths-pick").setInputFiles({ name: "slant.toml", mimeType: "text/plain", buffer: Buffer.from(text) });
  await page.locator("#paths-sum").getByText(sum).waitFor();
};

const tests = {
  async "what is drawn is where the file says, coloured by its speed"(url) {
    const { page, faults, context } = await open(url);
    assert.match(await page.locator("#paths-sum").innerText(), /^12 parts, 8\.2115 s, at most 60 mm\/s$/);
    const all = await rows(page);
    assert.match(all[0], /^1 Homing\s+0, 12\s+0\.97 s\s+–$/);
    assert.match(all[3], /^4 Arc\s+50, 10\s+0\.4142 s\s+60$/);
    assert.match(all[11], /^12 Arc\s+25, 10\s+2\.123 s\s+60$/);
    // On the canvas: the fast middle of a line and the circle's side, a corner where it rests, the arc
    // itself (45°), the corner of the square that the arc cuts off, and nothing.
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
    // With the axes exchanged the drawing is turned.
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
    // Behind the playhead in full colour, ahead pale; also when it moves on, and back again.
    const bright = async () => near((await colours(page, [[10, 25]]))[0], await pace(page, 1));
    const first = async () => near((await colours(page, [[13, 0]]))[0], await pace(page, 0.8));
    assert.deepEqual([await first(), await bright()], [true, false]);
    await seek(page, 7.95);
    assert.deepEqual([await first(), await bright()], [true, true]);
    await seek(page, 1.7);
    assert.deepEqual([await first(), await bright()], [true, false]);
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
    // A single motor is drawn over time.
    assert.equal(await page.locator("#paths-x").inputValue(), "-1");
    assert.match((await rows(page))[0], /^1 Moves\s+2\s+2 s\s+1$/);
    const text = page.locator("#paths-text");
    await text.fill(ONE.replace("delay-us = 1000", "delay = 1000"));
    await page.locator("#paths-wrong").getByText("lift.toml, line 7: unknown field `delay`").waitFor();
    // A space in the text is a space, and a corrected mistake is gone.
    await text.fill(ONE.replace("delay-us = 1000 }", "delay-us = 2000"));
    await text.focus();
    await page.keyboard.press("Control+End");
    await page.keyboard.press("ArrowLeft");
    for (const key of ["Space", "}"]) await page.keyboard.press(key);
    assert.match(await text.inputValue(), /2000 }\n$/);
    await page.locator("#paths-sum").getByText("1 part, 4 s, at most 0.5 mm/s").waitFor();
    assert.equal(await page.locator("#paths-wrong li").count(), 0);
    // The text is saved unchanged.
    const [saved] = await Promise.all([page.waitForEvent("download"), page.locator("#paths-save").click()]);
    assert.equal(saved.suggestedFilename(), "lift.toml");
    assert.equal(readFileSync(await saved.path(), "utf8"), await text.inputValue());
    // The examples are still there, and so is the user's own file.
    await choose(page, "triangle.toml");
    await page.locator("#paths-sum").getByText("4 parts, 78.336 s").waitFor();
    await choose(page, "lift.toml");
    await page.locator("#paths-sum").getByText("1 part").waitFor();
    assert.deepEqual(faults.filter((one) => !one.includes("422")), []);
    await context.close();
  },

  async "a run is followed by what the player says, to its end"(url) {
    const { page, faults, context } = await open(url);
    const other = await open(url);
    for (const one of [page, other.page]) await slant(one, SLANT, "1 part, 2.6001 s, at most 20 mm/s");
    await until("it can be run", () => page.locator("#paths-go").isEnabled());
    // A page that watches can't run a file.
    assert.ok(await other.page.locator("#paths-go").isDisabled());
    assert.equal(await page.locator("#paths-go").textContent(), "Run on a virtual board");
    await page.locator("#paths-go").click();
    await until("a part of it", async () => (await head(page)).time > 0.6);
    assert.ok(await page.locator("#paths-go").isDisabled());
    // Without news from the server the playhead stands.
    server.kill("SIGSTOP");
    await new Promise((later) => setTimeout(later, 300));
    const stood = await head(page);
    await new Promise((later) => setTimeout(later, 400));
    assert.deepEqual(await head(page), stood);
    server.kill("SIGCONT");
    const seen = [];
    await until("its end", async () => {
      seen.push(await head(page), await head(other.page));
      return (await page.locator("#paths-state.done").count()) === 1;
    });
    // On the line, at the place of that time, on both pages.
    const way = (t) => (t < 0.1 ? 100 * t * t : t > 2.5 ? 50 - 100 * (2.6001 - t) ** 2 : 20 * t - 1);
    const times = seen.map(({ time }) => time);
    assert.ok(new Set(times).size > 10, `${times}`);
    for (const { time, places } of seen) {
      const right = [0.8 * way(time), 0.6 * way(time)];
      assert.ok(places.every((place, i) => Math.abs(place - right[i]) < 0.06), `${time}: ${places} ${right}`);
    }
    await page.locator("#paths-state").getByText("slant.toml was run to its end: 2.60 s").waitFor();
    assert.deepEqual((await head(page)).places, [40, 30]);
    assert.deepEqual((await report(url)).places, [40e6, 30e6]);
    await ends(other.page, "done");
    // The user can set the time again.
    await seek(page, 0);
    assert.deepEqual((await head(page)).places, [0, 0]);
    assert.deepEqual(faults, []);
    await other.context.close();
    await context.close();
  },

  async "a stop brakes a run, also while its text is edited, and from a page that watches"(url) {
    const { page, context } = await open(url);
    const other = await open(url);
    await slant(page, SLOW, "at most 2 mm/s");
    await until("it can be run", () => page.locator("#paths-go").isEnabled());
    for (const stop of [
      () => page.keyboard.press("Space"),
      () => page.locator("#paths-text").press("Space"),
      () => page.locator("#stop").click(),
      async () => {
        await other.page.locator("#paths-state.running").waitFor();
        await other.page.keyboard.press("Space");
      },
    ]) {
      await page.locator("#paths-go").click();
      await until("it is on its way", async () => {
        const now = await report(url);
        return now?.state === "running" && now.seconds > 0.5;
      });
      await stop();
      await ends(page, "stopped");
      const { state, places } = await report(url);
      assert.equal(state, "stopped");
      assert.deepEqual((await head(page)).places, places.map((place) => place / 1e6));
      assert.ok(places[0] > 0.4e6 && places[0] < 39e6, `${places}`);
      // It has not left the line.
      assert.ok(Math.abs(places[0] * 0.75 - places[1]) <= 2 * 12_500, `${places}`);
      assert.equal(await page.locator("#paths-text").inputValue(), SLOW);
      await until("it can be run", () => page.locator("#paths-go").isEnabled());
    }
    // The same file as a command, for a board.
    await page.locator("#paths-copy").click();
    assert.equal(await page.locator("#paths-copied").innerText(), "stepwright cycle slant.toml --port PORT");
    await other.context.close();
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

/** The page from a host that knows no API. */
async function alone() {
  const { url, close } = await host(files);
  try {
    await drawn(url);
  } finally {
    close();
  }
}

async function drawn(url) {
  const { page, faults, context } = await open(url);
  assert.match(await page.locator("#paths-sum").innerText(), /^12 parts, 8\.2115 s, at most 60 mm\/s$/);
  const [side, inside] = await colours(page, [[10, 25], [25, 25]]);
  assert.ok(near(side, await pace(page, 1)) && !near(inside, await pace(page, 1)), `${side} ${inside}`);
  await choose(page, "feed.toml");
  await page.locator("#paths-sum").getByText("1 part, 4.3186 s, at most 60 mm/s").waitFor();
  await choose(page, "badge.nc");
  await page.locator("#paths-sum").getByText("17 parts, 26.645 s").waitFor();
  await page.locator("#paths-facts").getByText("26.645400 s").waitFor();
  // The plate has a laser.
  await choose(page, "engrave.nc");
  await page.locator("#paths-facts").getByText("Laser on").waitFor();
  assert.equal(await page.locator("#paths-most").textContent(), "full power");
  const [outline] = await colours(page, [[25, 0]]);
  assert.ok(near(outline, await pace(page, 1)), `${outline}`);
  // Another text needs the server, so no file is asked for, and nothing can be run.
  assert.ok(await page.locator("#paths-open").isHidden());
  await page.locator("#paths-text").fill(ONE);
  await page.locator("#paths-wrong").getByText("`stepwright serve` draws any file").waitFor();
  assert.ok(await page.locator("#paths-go").isHidden());
  await choose(page, "triangle.toml");
  await page.locator("#paths-sum").getByText("4 parts, 78.336 s").waitFor();
  assert.deepEqual(faults.filter((one) => !one.includes("404")), []);
  await context.close();
}

/** Light and dark, wide and narrow. */
async function pictures(url) {
  mkdirSync(folder, { recursive: true });
  const sizes = { wide: { viewport: { width: 1440, height: 1000 } }, phone: { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true } };
  for (const [size, options] of Object.entries(sizes)) {
    for (const scheme of ["light", "dark"]) {
      const { page, context } = await open(url, { ...options, colorScheme: scheme });
      if (size === "wide" && scheme === "dark") {
        // During a run.
        await until("it can be run", () => page.locator("#paths-go").isEnabled());
        await page.locator("#paths-go").click();
        await until("it is on the circle", async () => (await head(page)).time > 6.2);
      } else await seek(page, 7.9);
      await page.locator("h1").click();
      if (size === "phone") await page.evaluate(() => scrollTo(0, document.querySelector("#paths .right").offsetTop - 110));
      await page.evaluate(() => new Promise((on) => requestAnimationFrame(() => requestAnimationFrame(on))));
      await page.screenshot({ path: join(folder, `paths-${size}-${scheme}.png`) });
      await context.close();
    }
  }
}

let failed = 0;
const { child: server, said: url } = await serve("--virtual");
try {
  for (const [name, test] of [...Object.entries(tests), ["without a server the examples are drawn", alone]]) {
    try {
      await test(url);
      console.log(`passed: ${name}`);
    } catch (error) {
      failed++;
      console.log(`FAILED: ${name}\n${error.stack}`);
      for (const context of browser.contexts()) await context.close();
    }
    await until("control is free", async () => !(await (await fetch(`${url}api/state`)).json()).control?.live);
  }
  if (folder) await pictures(url);
} finally {
  await browser.close();
  for (const child of running) child.kill("SIGKILL");
}
process.exitCode = failed ? 1 : 0;
