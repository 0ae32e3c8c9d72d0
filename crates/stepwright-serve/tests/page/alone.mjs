// The page without a server: it drives a virtual board in a worker, without a network, and a board
// on a serial port of the browser. What it shows is held against the pins of the one, and against
// what the other says to a program.
//
//   node alone.mjs STEPWRIGHT CHROMIUM STATIC [FOLDER]
//
// STATIC is the folder of the page for any host, FOLDER one for pictures. Ends with 0 if all is as
// it should be.

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";

import { browser, host, running, until, watched } from "./common.mjs";
import * as wired from "./wired.mjs";

const [files, folder] = process.argv.slice(4);

const fill = (card, name, value) => card.locator(`[name=${name}]`).fill(String(value));
const click = (card, name) => card.locator(`[name=${name}]`).click();
const shown = async (card) => (await card.locator(".position").textContent()).trim();
const word = async (card) => (await card.locator(".state").textContent()).trim();
const moves = (card) => until("it moves", async () => (await word(card)) === "moving");
const rests = (card) => until("it rests", async () => (await word(card)) === "at rest" && shown(card));

/** A page, and the card of its first axis. */
async function open(url, options = {}, before) {
  const size = { viewport: { width: 1360, height: 900 }, ...options };
  const { context, page, faults } = await watched(url, size, before);
  const card = page.locator(".axis").first();
  await card.waitFor();
  // The question whether there is a server.
  return { context, page, card, faults: () => faults.filter((fault) => !fault.includes("404")) };
}

/** Steps of the first shaft, counted at the pins of the worker's board. */
const shaft = (page) => page.evaluate(async () => (await document.getElementById("board").keeper.wire.shafts())[0]);

const helpers = { open, fill, click, shown, word, moves, rests, until };

const tests = {
  async "it drives the worker's board, without a network"(url) {
    const { page, card, context, faults } = await open(url);
    const asked = [];
    page.on("request", (request) => asked.push(request.url()));
    await context.setOffline(true);
    await fill(card, "speed", 2000);
    await fill(card, "accel", 20000);
    await fill(card, "target", 700);
    await click(card, "to");
    await until("700 is shown", async () => (await shown(card)) === "700");
    assert.equal(await shaft(page), 700);
    await fill(card, "target", -200);
    await click(card, "by");
    await moves(card);
    assert.equal(await rests(card), "500");
    assert.equal(await shaft(page), 500);
    const lines = await page.locator("#lines").innerText();
    assert.match(lines, /G-200[\s\S]*travel by this many steps[\s\S]*accepted/);
    // Another target on the way, then another speed.
    await fill(card, "target", 1_000_000);
    await click(card, "to");
    await moves(card);
    await fill(card, "speed", 3000);
    await card.locator("[name=speed]").press("Tab");
    await until("it is faster", async () => parseFloat(await card.locator(".speed").textContent()) > 2500);
    await fill(card, "target", 0);
    await card.getByText("Retarget").click();
    await until("it is back", async () => (await shown(card)) === "0" && (await word(card)) === "at rest");
    assert.equal(await shaft(page), 0);
    assert.deepEqual(asked, []);
    assert.deepEqual(faults(), []);
    await context.close();
  },

  async "its plan is what the axis does"(url) {
    const { page, card, context } = await open(url);
    await page.evaluate(() => {
      const { keeper } = document.getElementById("board");
      const hear = keeper.told;
      window.heard = [];
      keeper.told = (message) => (window.heard.push(message), hear(message));
    });
    await fill(card, "speed", 1000);
    await fill(card, "accel", 2000);
    await fill(card, "target", -1500);
    await click(card, "to");
    await moves(card);
    assert.equal(await rests(card), "-1500");
    const heard = await page.evaluate(() => window.heard);
    const plan = heard.find((message) => message.type === "plan");
    assert.equal(plan.position.at(-1), -1500);
    // From 50 steps/s: up in 0.475 s, 0.95 s level, and down.
    assert.ok(Math.abs(plan.seconds.at(-1) - 1.95) < 0.1, `${plan.seconds.at(-1)}`);
    assert.ok(Math.abs(Math.min(...plan.speed) + 1000) < 10);
    const seen = heard.filter((message) => message.type === "state").map((message) => message.axes[0]);
    let compared = 0;
    for (const { time, position, moving } of seen.filter((axis) => axis.moving)) {
      const after = plan.seconds.findIndex((seconds) => plan.begin + seconds >= time);
      if (!moving || after < 1) continue;
      // An answer is some 20 ms old, on a loaded machine more.
      assert.ok(Math.abs(position - plan.position[after]) < 120, `${time}: ${position}`);
      compared++;
    }
    assert.ok(compared > 20, `${compared}`);
    // Of a run, and of a long travel, whose level way is not walked.
    for (const [act, end] of [[() => click(card, "run-ahead"), 1000 * 3600], [async () => {
      await fill(card, "target", 5_000_000);
      await click(card, "to");
    }, 5_000_000]]) {
      await page.evaluate(() => (window.heard = []));
      await act();
      await moves(card);
      await page.keyboard.press("Space");
      await rests(card);
      const { position, speed } = await page.evaluate(() => window.heard.find((message) => message.type === "plan"));
      assert.ok(position.at(-1) >= end - 1500 && position.length < 300, `${position.at(-1)}`);
      assert.ok(Math.max(...speed) > 990);
    }
    await context.close();
  },

  async "the button and the space bar brake its run, and keep the position"(url) {
    const { page, card, context } = await open(url);
    for (const stop of [
      () => page.locator("#stop").click(),
      () => page.keyboard.press("Space"),
      () => card.locator("[name=target]").press("Space"),
    ]) {
      await click(card, "run-ahead");
      await moves(card);
      await stop();
      const at = await rests(card);
      assert.equal(await shaft(page), Number(at));
      await card.getByText("Stopped by a soft stop").waitFor();
    }
    await context.close();
  },

  async "a kill loses the position, and it is called 0 again"(url) {
    const { page, card, context } = await open(url);
    await click(card, "run-ahead");
    await moves(card);
    await page.keyboard.press("Shift+K");
    await until("? is shown", async () => (await shown(card)) === "?");
    assert.ok(await card.locator("[name=to]").isDisabled());
    const at = await shaft(page);
    await new Promise((later) => setTimeout(later, 100));
    assert.equal(await shaft(page), at);
    await click(card, "zero");
    await until("0 is shown", async () => (await shown(card)) === "0");
    await page.getByRole("button", { name: "Acknowledge" }).click();
    await page.locator("#errors").waitFor({ state: "detached" });
    await context.close();
  },

  async "a jog runs while it is held"(url) {
    const { page, card, context } = await open(url);
    await fill(card, "speed", 800);
    await fill(card, "accel", 8000);
    await card.locator("[name=ahead]").hover();
    await page.mouse.down();
    await until("it has gone far", async () => (await shaft(page)) > 300);
    await page.mouse.up();
    const up = Number(await rests(card));
    await page.locator("h1").click();
    await page.keyboard.down("ArrowLeft");
    await until("it has come back", async () => (await shaft(page)) < up - 300);
    await page.keyboard.up("ArrowLeft");
    const at = Number(await rests(card));
    assert.ok(at < up - 300);
    assert.equal(await shaft(page), at);
    await fill(card, "step", 25);
    await click(card, "more");
    await until("a step was made", async () => Number(await shown(card)) === at + 25);
    await context.close();
  },

  async "its settings hold, and what the board refuses is told"(url) {
    const { page, card, context } = await open(url);
    await page.click('nav a[href="#settings"]');
    const pulse = page.locator("tr[data-name=pulse-us]");
    assert.match(await pulse.innerText(), /1 to 20 µs[\s\S]*STEP stays high/);
    await pulse.locator("input").fill("7");
    await pulse.locator("input").press("Enter");
    await pulse.getByText("changed", { exact: true }).waitFor();
    await pulse.locator("input").fill("21");
    await pulse.locator("input").press("Enter");
    await pulse.getByText("Allowed: 1 to 20 µs").waitFor();
    await page.click('nav a[href="#control"]');
    await fill(card, "speed", 900_000);
    await fill(card, "target", 400_000);
    await fill(card, "accel", 9_000_000);
    await click(card, "to");
    await page.locator("#notices").getByText("faster than the board can step").waitFor();
    await fill(card, "speed", 5_000_000);
    await click(card, "to");
    await page.locator("#notices").getByText("Allowed: 0.001 to 1000000 steps/s").waitFor();
    await context.close();
  },

  async "an axis is homed by the switch of its machine"(url) {
    const { page, card, context, faults } = await open(url);
    await click(card, "home");
    await page.locator("#notices").getByText("knows of no limit switch of axis 1").waitFor();
    await page.getByRole("button", { name: "Dismiss" }).click();
    await page.click('nav a[href="#settings"]');
    const switches = page.locator("tr[data-name=switches]");
    await switches.locator("input").fill("1");
    await switches.locator("input").press("Enter");
    await switches.getByText("changed", { exact: true }).waitFor();
    await page.click('nav a[href="#control"]');
    await card.locator("summary").click();
    await fill(card, "seek", 2000);
    await fill(card, "slow", 400);
    await click(card, "home");
    await card.getByText("seeks its switch").waitFor();
    assert.ok(await card.locator("[name=to]").isDisabled());
    await card.getByText("homed: 0 is where its switch closes").waitFor();
    await until("50 is shown", async () => (await shown(card)) === "50");
    // The switch closes at −1000 of the shaft, and is looked at each 100 µs.
    const at = await shaft(page);
    assert.ok(Math.abs(at + 950) <= 2, `${at}`);
    assert.equal(await page.locator("#errors").count(), 0);
    // A stop ends it, and so does a switch that is further than it may be.
    await fill(card, "back-off", 2000);
    await click(card, "home");
    await card.getByText("backs off").waitFor();
    await page.keyboard.press("Space");
    await card.getByText("Not homed: stopped before 0 was found").waitFor();
    await rests(card);
    await fill(card, "within", 100);
    await click(card, "home");
    await card.getByText("Not homed: no switch of axis 1 within 100 steps").waitFor();
    assert.deepEqual(faults(), []);
    await context.close();
  },

  async "the scope has the edges of its pins"(url) {
    const { page, card, context } = await open(url);
    await fill(card, "target", 40);
    await click(card, "to");
    await until("40 is shown", async () => (await shown(card)) === "40");
    await page.click('nav a[href="#scope"]');
    await page.locator("#scope-span").selectOption("10");
    await page.getByText("the edges of the virtual board's pins").waitFor();
    // Beside the view, which asks as well: each question has its answer.
    const [record] = await page.evaluate(() => {
      const { keeper } = document.getElementById("board");
      return Promise.race([
        Promise.all([keeper.scope(10), keeper.scope(10), keeper.scope(10)]),
        new Promise((_, fail) => setTimeout(() => fail(new Error("a question without an answer")), 10_000)),
      ]);
    });
    const step = record.signals.find((one) => one.name === "step1");
    assert.deepEqual([step.level, step.edges.length], [false, 80]);
    // Each pulse is 2 µs long.
    assert.ok(step.edges.every((ticks, n) => n % 2 === 0 || ticks === 32));
    assert.equal(record.signals.at(-1).name, "enable");
    await context.close();
  },

  async "it is small as a host sends it"(url) {
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

/** Light and dark, wide and narrow. */
async function pictures(url) {
  mkdirSync(folder, { recursive: true });
  for (const [size, colorScheme, viewport, more] of [
    ["wide", "light", { width: 1440, height: 1000 }, {}],
    ["wide", "dark", { width: 1440, height: 1000 }, {}],
    ["phone", "light", { width: 390, height: 844 }, { isMobile: true, hasTouch: true }],
    ["phone", "dark", { width: 390, height: 844 }, { isMobile: true, hasTouch: true }],
  ]) {
    const { page, card, context } = await open(url, { viewport, colorScheme, ...more });
    await page.locator("#span").selectOption("5").catch(() => {});
    await fill(card, "speed", 1500);
    await fill(card, "accel", 3000);
    await fill(card, "target", 7000);
    await click(card, "to");
    await new Promise((later) => setTimeout(later, 1000));
    await click(page.locator(".axis").nth(1), "run-ahead");
    await new Promise((later) => setTimeout(later, 2600));
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ path: join(folder, `alone-${size}-${colorScheme}.png`) });
    await context.close();
  }
}

let failed = 0;
const { url, close } = await host(files);
try {
  for (const [name, test] of Object.entries({ ...tests, ...wired.tests(helpers) })) {
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
  close();
  for (const child of running) child.kill("SIGKILL");
}
process.exitCode = failed ? 1 : 0;
