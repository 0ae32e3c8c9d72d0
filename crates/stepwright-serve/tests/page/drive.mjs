// A browser drives the page, and the API tells whether the board did what the page showed.
//
//   node drive.mjs STEPWRIGHT CHROMIUM [FOLDER]      pictures of every view go to FOLDER
//
// Ends with 0 if all tests pass. Playwright is found through NODE_PATH.

import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, rmSync, symlinkSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { browser, end, play, running, serve, start, until } from "./common.mjs";
import { click, fill, jogs, kills, lines, open, shown, stops, travels } from "./steps.mjs";
import * as care from "./care.mjs";
import * as views from "./views.mjs";

const folder = process.argv[4];

/** The board's state, as a program sees it. */
const state = async (url) => (await fetch(`${url}api/state`)).json();
const axis = async (url, number = 1) => (await state(url)).axes[number - 1];

const rests = (url, number = 1) =>
  until(`axis ${number} rests`, async () => {
    const one = await axis(url, number);
    return !one.moving && one;
  });
const moves = (url, number = 1) => until(`axis ${number} moves`, async () => (await axis(url, number)).moving);

const controls = (page) => page.locator("#release").waitFor();
/** A page that controls, and the API's position of its axis at rest. */
async function driver(url) {
  const opened = await open(url);
  await controls(opened.page);
  // After a kill there is no position.
  return { ...opened, at: async () => (await rests(url)).position ?? 0 };
}

const tests = {
  async "an axis travels where the page says, and the page shows where it is"(url) {
    const driven = await driver(url);
    await travels(driven);
    assert.deepEqual(driven.faults, []);
    await driven.context.close();
  },

  async "the button and the space bar brake, and keep the position"(url) {
    const driven = await driver(url);
    await stops(driven);
    const one = await rests(url);
    assert.deepEqual([one.state, one.stop.name], ["ready", "stop"]);
    await driven.context.close();
  },

  async "a kill is held, and loses the position"(url) {
    const driven = await driver(url);
    await kills(driven);
    await driven.context.close();
  },

  async "a jog runs while it is held"(url) {
    const driven = await driver(url);
    await jogs(driven);
    assert.equal((await rests(url)).state, "ready");
    await driven.context.close();
  },

  async "a line moves axes together, and leaves the others"(url) {
    const driven = await driver(url);
    await lines(driven);
    const places = (await state(url)).axes.map((one) => one.position);
    assert.deepEqual(places.slice(1), [900, 0]);
    assert.deepEqual(driven.faults.filter((one) => !one.includes("422")), []);
    await driven.context.close();
  },

  async "one page controls, another watches and may stop, and may take over"(url) {
    const first = await open(url);
    await controls(first.page);
    const second = await open(url);
    await second.page.getByText("controls, you watch").waitFor();
    assert.ok(await second.card.locator("[name=to]").isDisabled());
    await click(first.card, "run-ahead");
    await second.card.getByText("moving").waitFor();
    await second.page.locator("#stop").click();
    assert.equal((await rests(url)).state, "ready");
    const place = String((await axis(url)).position);
    for (const { card } of [first, second]) await until("both agree", async () => (await shown(card)) === place);
    // Taking over ends the run of the other page.
    await click(first.card, "run-ahead");
    await moves(url);
    await second.page.getByRole("button", { name: "Take over" }).click();
    await rests(url);
    await controls(second.page);
    await first.page.getByText("controls, you watch").waitFor();
    await first.page.locator("#notices").getByText(/^page \d+ has taken control: you watch now$/).waitFor();
    // A closed page runs nothing.
    await click(second.card, "run-back");
    await moves(url);
    await second.context.close();
    assert.equal((await rests(url)).stop.name, "stop");
    await first.page.getByRole("button", { name: "Take control" }).click();
    await controls(first.page);
    await first.context.close();
  },

  async "on a phone nothing is cut off"(url) {
    for (const width of [320, 360, 390]) {
      const { page, context } = await open(url, { viewport: { width, height: 740 }, isMobile: true, hasTouch: true });
      for (const view of await page.locator("nav a").evaluateAll((all) => all.map((one) => one.hash))) {
        await page.evaluate((view) => (location.hash = view), view);
        const cut = await page.evaluate(() => {
          const room = document.scrollingElement.clientWidth;
          const wide = document.scrollingElement.scrollWidth > room ? ["the page"] : [];
          const cut = [...document.querySelectorAll("main button, footer button, footer small")].filter((one) => {
            const { right, width } = one.getBoundingClientRect();
            return width && (one.scrollWidth > one.clientWidth + 1 || right > room);
          });
          return [...wide, ...cut.map((one) => one.innerText)];
        });
        assert.deepEqual(cut, [], `${view} at ${width}`);
      }
      await context.close();
    }
  },

  async "the page is small, and quickly there"(url) {
    const { page, context } = await open(url);
    const [bytes, paint] = await page.evaluate(() => [
      performance.getEntriesByType("resource").reduce((sum, one) => sum + one.encodedBodySize, 0),
      performance.getEntriesByName("first-contentful-paint")[0]?.startTime,
    ]);
    console.log(`  ${bytes} bytes beside the HTML, first paint after ${Math.round(paint)} ms`);
    assert.ok(bytes > 60_000 && bytes <= 300_000, `${bytes}`);
    await context.close();
  },
};

/** A board on a pseudo-terminal that vanishes, and comes back. */
async function vanishing() {
  const place = mkdtempSync(join(tmpdir(), "stepwright-page-"));
  const name = join(place, "port");
  const plug = async () => {
    const { child, said } = await start("pty ", "board", "--pty");
    rmSync(name, { force: true });
    symlinkSync(said, name);
    return child;
  };
  let board = await plug();
  const { child, said: url } = await serve("--port", name);
  const { page, card, context } = await open(url);
  await controls(page);
  await click(card, "run-ahead");
  await moves(url);
  await end(board);
  await card.getByText("no board").waitFor();
  assert.equal(await shown(card), "?");
  await page.locator("#notices").getByText("it is met again").waitFor();
  board = await plug();
  await until("0 is shown", async () => (await shown(card)) === "0");
  assert.equal((await axis(url)).moving, false);
  await fill(card, "target", 60);
  await click(card, "to");
  await until("60 is shown", async () => (await shown(card)) === "60");
  // The page also tells that the server is gone.
  await end(child);
  await page.getByText("The server does not answer").waitFor();
  await context.close();
  await end(board);
  rmSync(place, { recursive: true });
}

/** Every view, light and dark, wide and narrow. */
async function pictures(url) {
  mkdirSync(folder, { recursive: true });
  for (const colorScheme of ["light", "dark"]) {
    for (const [size, viewport, more] of [
      ["wide", { width: 1440, height: 1000 }, {}],
      ["phone", { width: 390, height: 844 }, { isMobile: true, hasTouch: true }],
    ]) {
      const { page, card, context } = await open(url, { viewport, colorScheme, ...more });
      await controls(page);
      const old = page.getByRole("button", { name: "Acknowledge" });
      if (await old.isVisible()) await old.click();
      await page.evaluate(() => {
        const span = document.getElementById("span");
        span.value = "5";
        span.dispatchEvent(new Event("change"));
      });
      await fill(card, "speed", 1500);
      await fill(card, "accel", 3000);
      await fill(card, "target", (await axis(url)).position > 2500 ? -1000 : 7000);
      await click(card, "to");
      await new Promise((later) => setTimeout(later, 1000));
      const second = page.locator(".axis").nth(1);
      await fill(second, "speed", 800);
      await click(second, "run-ahead");
      await new Promise((later) => setTimeout(later, 2600));
      const shot = (view) => page.screenshot({ path: join(folder, `${view}-${size}-${colorScheme}.png`) });
      await page.evaluate(() => scrollTo(0, 0));
      await shot("control");
      if (size === "phone") {
        for (const view of ["plots", "talk"]) {
          await page.click(`nav a[href="#${view}"]`);
          await new Promise((later) => setTimeout(later, 200));
          await shot(view);
        }
      }
      await page.locator("#stop").click();
      await rests(url, 2);
      await rests(url);
      await page.locator("#release").click();
      await context.close();
    }
  }
}

let failed = 0;
try {
  const { child, said: url } = await serve("--virtual", "--switch", "1:-300");
  const helpers = { start, serve, end, driver, open, controls, until, rests, moves, axis, click, fill };
  const all = Object.entries({ ...care.tests(helpers), ...views.tests(helpers), ...tests }).map(([name, test]) => [name, () => test(url)]);
  failed += await play(Object.fromEntries(all), async (broken) => {
    // The next test begins with a board at rest, and nobody in control.
    const stop = { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" };
    if (broken) await fetch(`${url}api/stop`, stop);
    await until("control is free", async () => !(await state(url)).control?.live);
  });
  failed += await play({ "a board that vanishes is met again, and nothing moves by itself": vanishing });
  if (folder) {
    await pictures(url);
    await views.pictures({ start, end, open, controls, until, rests, axis, click, fill, folder });
  }
  await end(child);
} finally {
  await browser.close();
  for (const child of running) child.kill("SIGKILL");
}
process.exitCode = failed ? 1 : 0;
