// The page without a server: it drives a virtual board of its own, without a network, and a board
// on a serial port of the browser. The page is compared with the pins of the virtual board, and with
// what the other board tells a program.
//
//   node alone.mjs STEPWRIGHT CHROMIUM STATIC [FOLDER]
//
// STATIC is the folder of the page for any host, FOLDER one for pictures. Ends with 0 if all tests
// pass.

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";

import { browser, host, play, running, until } from "./common.mjs";
import { click, fill, homes, jogs, kills, lines, moves, open, rests, sets, shown, stops, travels } from "./steps.mjs";
import { accessible } from "./care.mjs";
import * as wired from "./wired.mjs";

const [files, folder] = process.argv.slice(4);

/** Steps of the first shaft, counted at the pins of the page's board. */
const shaft = (page) => page.evaluate(() => document.getElementById("board").keeper.wire.board.shafts()[0]);

/** A page, and the position of its first shaft. */
async function alone(url) {
  const opened = await open(url);
  return { ...opened, at: () => shaft(opened.page), faults: () => served(opened.faults) };
}

/** Faults, without the question whether there is a server. */
const served = (faults) => faults.filter((fault) => !fault.includes("404"));

const tests = {
  async "it drives the board of the page, without a network"(url) {
    const { page, context, faults, ...driven } = await alone(url);
    const asked = [];
    page.on("request", (request) => asked.push(request.url()));
    await context.setOffline(true);
    await travels({ page, ...driven });
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
    // From 50 steps/s: up in 0.475 s, 0.95 s at top speed, and down.
    assert.ok(Math.abs(plan.seconds.at(-1) - 1.95) < 0.1, `${plan.seconds.at(-1)}`);
    assert.ok(Math.abs(Math.min(...plan.speed) + 1000) < 10);
    const seen = heard.filter((message) => message.type === "state").map((message) => message.axes[0]);
    let compared = 0;
    for (const { time, position, moving } of seen.filter((axis) => axis.moving)) {
      const after = plan.seconds.findIndex((seconds) => plan.begin + seconds >= time);
      if (!moving || after < 1) continue;
      // Between two points the plan is a straight line.
      const [from, to] = [after - 1, after].map((n) => ({ at: plan.position[n], s: plan.seconds[n] }));
      const due = from.at + ((time - plan.begin - from.s) / (to.s - from.s)) * (to.at - from.at);
      // An answer is some 20 ms old, on a busy computer more.
      assert.ok(Math.abs(position - due) < 120, `${time}: ${position}, not ${due}`);
      compared++;
    }
    assert.ok(compared > 20, `${compared}`);
    // A run, and a long travel that is stopped before its end.
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
    const driven = await alone(url);
    await stops(driven);
    await driven.context.close();
  },

  async "a kill loses the position, and it is called 0 again"(url) {
    const driven = await alone(url);
    await kills(driven);
    await driven.context.close();
  },

  async "a jog runs while it is held"(url) {
    const driven = await alone(url);
    await jogs(driven);
    await driven.context.close();
  },

  async "a line moves axes together, and leaves the others"(url) {
    const driven = await alone(url);
    await lines(driven);
    await driven.context.close();
  },

  async "its settings hold, and what the board refuses is told"(url) {
    const { page, card, context } = await open(url);
    await sets({ page });
    await fill(card, "speed", 900_000);
    await fill(card, "target", 400_000);
    await fill(card, "accel", 9_000_000);
    await click(card, "to");
    await page.locator("#notices").getByText("faster than the board can step").waitFor();
    // The field would refuse it itself.
    await fill(card, "speed", 5_000_000);
    await card.locator("[name=speed]").evaluate((one) => (one.max = ""));
    await click(card, "to");
    await page.locator("#notices").getByText("Allowed: 0.001 to 1000000 steps/s").waitFor();
    await context.close();
  },

  async "an axis is homed by the switch of its machine"(url) {
    const driven = await alone(url);
    // The switch closes at −1000 of the shaft, and is sampled every 100 µs.
    const place = await homes(driven);
    assert.ok(Math.abs(place + 950) <= 2, `${place}`);
    const { card, context, faults } = driven;
    // A switch that is too far away ends the homing.
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
    // While the view asks too: each question has its answer.
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

  async "lengths are in the unit of a machine that the browser keeps"(url) {
    const { page, card, context, at, faults } = await alone(url);
    const unit = () => card.locator(".unit").first().textContent();
    assert.equal(await unit(), "steps");
    await page.click('nav a[href="#settings"]');
    const form = page.locator("#machine");
    await form.locator("[name=unit]").selectOption("mm");
    await form.locator("[name=mm-1]").fill("5");
    // The buttons of a setting are side by side.
    const buttons = page.locator("tr[data-name=max-speed] button");
    const [set, reset] = await Promise.all([0, 1].map((n) => buttons.nth(n).boundingBox()));
    assert.ok(set.y === reset.y && set.x < reset.x, JSON.stringify([set, reset]));
    await form.getByText("640 steps/mm").waitFor();
    // A travel of 0 mm per turn is refused by the form itself.
    await form.locator("[name=mm-2]").fill("0");
    await form.getByRole("button", { name: "Save" }).click();
    await page.click('nav a[href="#control"]');
    assert.equal(await unit(), "steps");
    await page.click('nav a[href="#settings"]');
    await form.locator("[name=mm-2]").fill("8");
    await form.getByRole("button", { name: "Save" }).click();
    await form.getByText("Kept by this browser.").waitFor();
    await page.click('nav a[href="#control"]');
    await until("it is in mm", async () => (await unit()) === "mm");
    await fill(card, "speed", 4);
    await fill(card, "target", 1.5);
    await click(card, "to");
    await until("1.5 is shown", async () => (await shown(card)) === "1.5");
    assert.equal(await rests(card), "1.5");
    assert.equal(await at(), 960);
    assert.match(await card.locator(".speed").textContent(), /960 steps/);
    // Small parts of a unit have enough digits: 10 steps/s.
    await card.locator("[name=speed-slide]").fill("0");
    assert.equal(await card.locator("[name=speed]").inputValue(), "0.0156");
    await fill(card, "speed", 4);
    // Not while a motor moves.
    await click(card, "run-ahead");
    await moves(card);
    await page.click('nav a[href="#settings"]');
    await form.locator("[name=unit]").selectOption("deg");
    await form.getByText("8.88888889 steps/deg").first().waitFor();
    await form.getByRole("button", { name: "Save" }).click();
    await form.getByText("Not while a motor moves").waitFor();
    await page.locator("#stop").click();
    await page.click('nav a[href="#control"]');
    await rests(card);
    assert.equal(await unit(), "mm");
    // Values that the unit does not need are disabled, and keep their old values.
    await page.click('nav a[href="#settings"]');
    await form.locator("[name=unit]").selectOption("mm");
    await form.locator("[name=mm-2]").fill("");
    await form.locator("[name=unit]").selectOption("deg");
    await form.getByRole("button", { name: "Save" }).click();
    await form.getByText("Kept by this browser.").waitFor();
    await form.locator("[name=micro-2]").fill("");
    await form.locator("[name=unit]").selectOption("steps");
    await form.getByRole("button", { name: "Save" }).click();
    await form.getByText("Kept by this browser.").waitFor();
    await form.locator("[name=unit]").selectOption("mm");
    assert.deepEqual([await form.locator("[name=mm-2]").inputValue(), await form.locator("[name=micro-2]").inputValue()], ["8", "16"]);
    await form.getByRole("button", { name: "Save" }).click();
    await form.getByText("Kept by this browser.").waitFor();
    await page.click('nav a[href="#control"]');
    // The machine is kept; a damaged one counts as none.
    await page.reload();
    await until("it is kept", async () => (await unit()) === "mm");
    await page.evaluate(() => localStorage.setItem("stepwright-machine", '{"unit":"mm","axes":[{"steps":0}]}'));
    await page.reload();
    await card.waitFor();
    assert.equal(await unit(), "steps");
    assert.deepEqual(faults(), []);
    await context.close();
  },

  async "what could not be loaded is said, or tried again when it is asked for again"(url) {
    const { page, context } = await open(url);
    // The planner's module.
    await page.route("**/plan.wasm", (route) => route.abort());
    await page.click('nav a[href="#plan"]');
    await page.locator("#notices").getByText("Failed to fetch").waitFor();
    await page.unroute("**/plan.wasm");
    for (const view of ["control", "plan"]) await page.click(`nav a[href="#${view}"]`);
    await page.locator("#laws td:nth-child(2)").first().getByText(" s").waitFor();
    // A module that the page needs.
    await page.route("**/host.wasm", (route) => route.fulfill({ status: 503 }));
    await page.reload();
    await page.locator("#notices").getByText("The page could not be loaded (../host.wasm: 503): load it again.").waitFor();
    await context.close();
  },

  async "every view is accessible"(url) {
    const { page, context } = await open(url);
    await accessible(page);
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
    await page.locator("#stop").click();
    await rests(page.locator(".axis").nth(1));
    await page.click('nav a[href="#settings"]');
    await page.selectOption("#machine [name=unit]", "mm");
    await page.locator("#machine button").click();
    await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
    await page.screenshot({ path: join(folder, `machine-${size}-${colorScheme}.png`) });
    await context.close();
  }
}

let failed = 0;
const { url, close } = await host(files);
try {
  const all = Object.entries({ ...tests, ...wired.tests }).map(([name, test]) => [name, () => test(url)]);
  failed = await play(Object.fromEntries(all));
  if (folder) await pictures(url);
} finally {
  await browser.close();
  close();
  for (const child of running) child.kill("SIGKILL");
}
process.exitCode = failed ? 1 : 0;
