// What the page owes to people in a hurry, and to people who can't see it: outdated values are not
// drawn, a stop that reaches nobody says so, and every view is accessible.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

import { browser } from "./common.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Checks that axe finds nothing in any view, light or dark. */
export async function accessible(page) {
  // Past the policy of the page, as a debugger can.
  await page.evaluate(AXE);
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    for (const view of await page.locator("nav a").evaluateAll((all) => all.map((one) => one.hash))) {
      await page.evaluate((view) => (location.hash = view), view);
      await page.locator(`${view}.shown`).waitFor();
      const { violations, passes } = await page.evaluate(() => globalThis.axe.run());
      const found = violations.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 120)} ${node.any[0]?.message ?? node.failureSummary}`));
      assert.deepEqual(found, [], `${view}, ${colorScheme}`);
      assert.ok(passes.length > 10, `${passes.length}`);
    }
  }
}

/** How much of the planned line of axis 1 is drawn at a time, in each chart, in pixels. */
const drawn = (page, time) =>
  page.evaluate(async (time) => {
    const { plots } = document.getElementById("charts").plots;
    for (const plot of plots) plot.series.forEach((_, n) => n > 1 && plot.setSeries(n, { show: false }));
    await new Promise((later) => requestAnimationFrame(() => requestAnimationFrame(later)));
    return plots.map((plot) => {
      const [r, g, b] = plot.series[1].stroke().match(/\d+/g).map(Number);
      const x = Math.round(plot.valToPos(time, "x", true));
      const { data } = plot.ctx.getImageData(x, 0, 1, plot.ctx.canvas.height);
      let count = 0;
      for (let n = 0; n < data.length; n += 4) {
        const [near, pale] = [[r, g, b].every((one, i) => Math.abs(one - data[n + i]) < 12), data[n + 3] > 40 && data[n + 3] < 160];
        count += near && pale;
      }
      return count;
    });
  }, time);

/** The tests, with the helpers of drive.mjs. */
export function tests({ start, serve, end, open, controls, until, rests, moves, click, fill }) {
  return {
    async "a planned line ends with its plan"(url) {
      const { page, card, context } = await open(url);
      await controls(page);
      await fill(card, "speed", 1000);
      await fill(card, "accel", 10_000);
      for (const by of [500, -500]) {
        await fill(card, "target", by);
        await click(card, "by");
        await moves(url);
        await rests(url);
        await new Promise((later) => setTimeout(later, 800));
      }
      await page.locator("#pause").click();
      const [first, second] = await page.evaluate(() => {
        const plans = document.getElementById("charts").plots.axes[0].plans.slice(-2);
        return plans.map(({ begin, seconds }) => [begin, begin + seconds.at(-1)]);
      });
      assert.ok(second[0] - first[1] > 0.5, `${first} ${second}`);
      for (const [begin, last] of [first, second]) assert.ok((await drawn(page, (begin + last) / 2)).every((count) => count > 2));
      assert.deepEqual(await drawn(page, (first[1] + second[0]) / 2), [0, 0, 0]);
      await context.close();
    },

    async "two plans are two lines"(url) {
      const { page, card, context } = await open(url);
      await card.waitFor();
      const line = await page.evaluate(() => {
        const { plots } = document.getElementById("charts");
        const [seconds, speed, middle] = [[0, 5], [20, 20], plots.now - 1];
        // A homing's new 0 lies between them.
        plots.axes[0].plans = [
          { begin: middle - 1, until: middle, seconds, speed, position: [0, 100] },
          { begin: middle, seconds, speed, position: [500, 600] },
        ];
        plots.draw(true);
        return plots.plots[0].data[1].filter((place) => place !== undefined).map((place) => place && Math.round(place));
      });
      assert.deepEqual(line.slice(0, 4), [0, 20, null, 500]);
      await context.close();
    },

    async "without a server the page says how to stop, and comes back with it"() {
      const { child, said: url } = await serve("--virtual");
      const { page, card, context } = await open(url);
      await controls(page);
      const struck = () => page.locator("#stop .word").evaluate((word) => getComputedStyle(word).textDecorationLine === "line-through");
      assert.equal(await struck(), false);
      await click(card, "run-ahead");
      await moves(url);
      await end(child);
      await page.locator("#stop").getByText("No answer: switch off the motor's power").waitFor();
      assert.equal(await struck(), true);
      await page.locator("#plots").getByText("Nothing is heard of the board: these are the last values").waitFor();
      const window = () => page.evaluate(() => document.getElementById("charts").plots.window());
      const frozen = await window();
      await new Promise((later) => setTimeout(later, 500));
      assert.deepEqual(await window(), frozen);
      await page.locator("#stop").click();
      // A view that is opened now is there when the server is.
      for (const view of ["scope", "plan"]) await page.click(`nav a[href="#${view}"]`);
      await page.locator("#notices").getByText("the server does not answer").waitFor();
      assert.equal(await page.locator("#notices p").count(), 1);
      // A restarted server counts its time from 0.
      const again = await start("page ", "serve", "--machine", "none", "--virtual", "--bind", new URL(url).host);
      await until("Stop is back", async () => !(await struck()));
      await page.locator("#laws td:nth-child(2)").first().getByText(" s").waitFor();
      assert.deepEqual(await page.locator("#notices p").allInnerTexts(), []);
      await page.click('nav a[href="#scope"]');
      await page.locator("#scope-source").getByText("the edges of the virtual board's pins").waitFor();
      await page.click('nav a[href="#control"]');
      await controls(page);
      await fill(card, "target", 300);
      await click(card, "to");
      await rests(url);
      await until("it is plotted", () => page.evaluate(() => {
        const [axis] = document.getElementById("charts").plots.axes;
        return axis.track.points.at(-1)[1] === 300 && axis.plans.length === 1;
      }));
      await context.close();
      await end(again.child);
    },

    async "without its token the page says where the token is"() {
      const { child, said: url } = await start("page ", "serve", "--machine", "none", "--virtual", "--bind", "0.0.0.0:0");
      const [bare, token] = url.split("#");
      const context = await browser.newContext();
      for (const address of [bare, `${bare}#${token.slice(0, -1)}-`]) {
        const page = await context.newPage();
        await page.goto(address);
        await page.getByText("This server asks for a token: open the whole address").waitFor();
        await page.close();
      }
      const { page, context: second } = await open(url);
      await controls(page);
      await context.close();
      await second.close();
      await end(child);
    },

    async "what could not be asked is asked again"(url) {
      let asked = 0;
      // The first request asks whether there is a server.
      const before = (page) => page.route("**/api/board", (route) => (asked++ === 1 ? route.abort() : route.continue()));
      const { page, context } = await open(url, {}, before);
      await page.locator("#notices").getByText("the server does not answer").waitFor();
      await page.getByRole("button", { name: "Dismiss" }).click();
      for (const [view, there, ...asked] of [
        ["calc", ".result h3", "**/calc.js", "**/api/calc"],
        ["paths", "#paths-legs tbody tr", "**/api/path/examples"],
        ["plan", "#laws td:nth-child(2)", "**/plan.wasm"],
      ]) {
        const look = async () => {
          await page.click('nav a[href="#control"]');
          await page.click(`nav a[href="#${view}"]`);
        };
        for (const one of asked) {
          await page.route(one, (route) => route.abort());
          await look();
          await page.getByRole("button", { name: "Dismiss" }).click();
          await page.unroute(one);
        }
        await look();
        await page.locator(there).first().waitFor();
      }
      await context.close();
    },

    async "what is to be acknowledged stays, however much is told"(url) {
      const { page, card, context } = await open(url);
      await controls(page);
      await click(card, "run-ahead");
      await moves(url);
      await page.keyboard.press("Shift+K");
      await page.locator("#errors").waitFor();
      await rests(url);
      await click(card, "zero");
      // The field would refuse them itself.
      await card.locator("[name=speed]").evaluate((one) => (one.max = ""));
      for (const speed of [5e6, 6e6, 7e6, 8e6, 9e6]) {
        await fill(card, "speed", speed);
        await click(card, "run-ahead");
        await page.locator("#notices").getByText(String(speed / 1e6)).first().waitFor();
      }
      assert.equal(await page.locator("#notices p").count(), 4);
      await page.getByRole("button", { name: "Acknowledge" }).click();
      await page.locator("#errors").waitFor({ state: "detached" });
      await context.close();
    },

    async "a key moves no axis that is not seen"(url) {
      const { page, context } = await open(url, { viewport: { width: 700, height: 800 } });
      await controls(page);
      const from = (await rests(url)).position;
      await page.click('nav a[href="#talk"]');
      await page.keyboard.down("ArrowRight");
      await new Promise((later) => setTimeout(later, 400));
      await page.keyboard.up("ArrowRight");
      assert.equal((await rests(url)).position, from);
      await context.close();
    },

    async "every view is accessible"(url) {
      const { page, card, context } = await open(url);
      await controls(page);
      await click(card, "run-ahead");
      await moves(url);
      await page.locator("#stop").click();
      await rests(url);
      await accessible(page);
      for (const name of ["Position in steps", "Speed over time"]) assert.equal(await page.locator(`canvas[role=img][aria-label="${name}"]`).count(), 1);
      // Values that change many times a second are not read out.
      assert.equal(await page.locator(".axis :is(.position, .speed):is(output, [role], [aria-live])").count(), 0);
      await context.close();
    },
  };
}
