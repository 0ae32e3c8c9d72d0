// A browser drives the page, and the API says whether the board did what the page showed.
//
//   node drive.mjs STEPWRIGHT CHROMIUM [FOLDER]      pictures of every view go to FOLDER
//
// Ends with 0 if all is as it should be. Playwright is found through NODE_PATH.

import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, rmSync, symlinkSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { browser, running, serve, start, until, watched } from "./common.mjs";
import * as views from "./views.mjs";

const folder = process.argv[4];

const end = (child) => new Promise((ended) => (child.on("exit", ended), child.kill("SIGKILL")));

/** What the board does, as a program sees it. */
const state = async (url) => (await fetch(`${url}api/state`)).json();
const axis = async (url, number = 1) => (await state(url)).axes[number - 1];

const rests = (url, number = 1) =>
  until(`axis ${number} rests`, async () => {
    const one = await axis(url, number);
    return !one.moving && one;
  });
const moves = (url, number = 1) => until(`axis ${number} moves`, async () => (await axis(url, number)).moving);

/** A page that is watched for errors, and the card of its first axis. */
async function open(url, options = {}) {
  const { context, page, faults } = await watched(url, { viewport: { width: 1360, height: 900 }, ...options });
  const card = page.locator(".axis").first();
  await card.waitFor();
  return { context, page, card, faults };
}

const controls = (page) => page.locator("#release").waitFor();
const fill = async (card, name, value) => card.locator(`[name=${name}]`).fill(String(value));
const click = async (card, name) => card.locator(`[name=${name}]`).click();
const shown = async (card) => (await card.locator(".position").textContent()).trim();

const tests = {
  async "an axis travels where the page says, and the page shows where it is"(url) {
    const { page, card, faults, context } = await open(url);
    await controls(page);
    await fill(card, "speed", 2000);
    await fill(card, "accel", 20000);
    await fill(card, "target", 700);
    await click(card, "to");
    await until("700 is shown", async () => (await shown(card)) === "700");
    assert.equal((await rests(url)).position, 700);
    await fill(card, "target", -200);
    await click(card, "by");
    await moves(url);
    await rests(url);
    await until("500 is shown", async () => (await shown(card)) === "500");
    assert.equal((await axis(url)).position, 500);
    // The order was told line by line, each with its meaning.
    const lines = await page.locator("#lines").innerText();
    assert.match(lines, /G-200[\s\S]*travel by this many steps[\s\S]*accepted/);
    // Another target on the way.
    await fill(card, "target", 1_000_000);
    await click(card, "to");
    await moves(url);
    await fill(card, "target", 0);
    await card.getByText("Retarget").click();
    assert.equal((await rests(url)).position, 0);
    assert.deepEqual(faults, []);
    await context.close();
  },

  async "the button and the space bar brake, and keep the position"(url) {
    const { page, card, context } = await open(url);
    await controls(page);
    for (const stop of [
      () => page.locator("#stop").click(),
      () => page.keyboard.press("Space"),
      // Also from within a field, and from another button.
      () => card.locator("[name=target]").press("Space"),
      () => card.locator("[name=run-back]").press("Space"),
    ]) {
      await click(card, "run-ahead");
      await moves(url);
      await stop();
      const one = await rests(url);
      assert.equal(one.state, "ready");
      assert.equal(one.stop.name, "brake");
    }
    await until("the place is shown", async () => (await shown(card)) === String((await axis(url)).position));
    await context.close();
  },

  async "a kill is held, and loses the position"(url) {
    const { page, card, context } = await open(url);
    await controls(page);
    await click(card, "run-ahead");
    await moves(url);
    // A touch by accident does nothing.
    await page.locator("#kill").click();
    await new Promise((later) => setTimeout(later, 900));
    assert.equal((await axis(url)).moving, true);
    await page.locator("#kill").hover();
    await page.mouse.down();
    await until("it is killed", async () => (await axis(url)).state === "uncertain");
    await page.mouse.up();
    await until("? is shown", async () => (await shown(card)) === "?");
    assert.ok(await card.locator("[name=to]").isDisabled());
    await click(card, "zero");
    await until("0 is shown", async () => (await shown(card)) === "0");
    await page.getByRole("button", { name: "Acknowledge" }).click();
    await page.locator("#errors").waitFor({ state: "detached" });
    // On a key it needs no holding.
    await click(card, "run-back");
    await moves(url);
    await page.keyboard.press("Shift+K");
    await until("it is killed", async () => (await axis(url)).state === "uncertain");
    await click(card, "zero");
    await context.close();
  },

  async "a jog runs while it is held"(url) {
    const { page, card, context } = await open(url);
    await controls(page);
    await fill(card, "speed", 800);
    await fill(card, "accel", 8000);
    const from = (await rests(url)).position;
    await card.locator("[name=ahead]").hover();
    await page.mouse.down();
    await until("it has gone far", async () => (await axis(url)).position > from + 300);
    await page.mouse.up();
    const up = (await rests(url)).position;
    await page.locator("h1").click();
    await page.keyboard.down("ArrowLeft");
    await until("it has come back", async () => (await axis(url)).position < up - 300);
    await page.keyboard.up("ArrowLeft");
    const { position, state: word } = await rests(url);
    assert.ok(position < up - 300 && word === "ready");
    // A tap is a short run, never an endless one.
    await page.keyboard.press("ArrowRight");
    await new Promise((later) => setTimeout(later, 400));
    await rests(url);
    await fill(card, "step", 25);
    const at = (await rests(url)).position;
    await click(card, "more");
    await until("a step was made", async () => (await axis(url)).position === at + 25);
    await context.close();
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
    // Who takes over ends the run of the one before.
    await click(first.card, "run-ahead");
    await moves(url);
    await second.page.getByRole("button", { name: "Take over" }).click();
    await rests(url);
    await controls(second.page);
    await first.page.getByText("controls, you watch").waitFor();
    // A page that is closed runs nothing.
    await click(second.card, "run-back");
    await moves(url);
    await second.context.close();
    assert.equal((await rests(url)).stop.name, "brake");
    await first.page.getByRole("button", { name: "Take control" }).click();
    await controls(first.page);
    await first.context.close();
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

/** A board on a pseudo-terminal that goes, and comes back. */
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
  // A server that is gone is told, too.
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
  const more = views.tests({ open, controls, until, rests, moves, axis, shown, click, fill });
  for (const [name, test] of Object.entries({ ...more, ...tests })) {
    try {
      await test(url);
      console.log(`passed: ${name}`);
    } catch (error) {
      failed++;
      console.log(`FAILED: ${name}\n${error.stack}`);
      // The next one begins with a board at rest, and nobody who controls.
      await fetch(`${url}api/stop`, { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" });
      for (const context of browser.contexts()) await context.close();
    }
    await until("control is free", async () => !(await state(url)).control?.live);
  }
  try {
    await vanishing();
    console.log("passed: a board that vanishes is met again, and nothing moves by itself");
  } catch (error) {
    failed++;
    console.log(`FAILED: a board that vanishes\n${error.stack}`);
  }
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
