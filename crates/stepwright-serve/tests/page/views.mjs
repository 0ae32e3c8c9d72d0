// The views beside the controls: homing, settings, scope.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { homes } from "./steps.mjs";

const { McapIndexedReader } = createRequire(import.meta.url)("@mcap/core");

/** The contents of an MCAP file by another reader: for each topic [ns, level] … */
async function recorded(file) {
  const readable = { size: async () => BigInt(file.length), read: async (at, count) => file.subarray(Number(at), Number(at + count)) };
  const reader = await McapIndexedReader.Initialize({ readable });
  const topics = Object.fromEntries([...reader.channelsById.values()].map(({ topic }) => [topic, []]));
  for await (const { channelId, logTime, data } of reader.readMessages()) {
    topics[reader.channelsById.get(channelId).topic].push([Number(logTime), JSON.parse(new TextDecoder().decode(data)).level]);
  }
  return topics;
}

/** The tests, with the helpers of drive.mjs. Their machine has a switch of axis 1 at -300. */
export function tests({ start, end, driver, open, controls, until, rests, moves, axis, click, fill }) {
  const view = async (page, name) => {
    await page.click(`nav a[href="#${name}"]`);
    await page.locator(`#${name}`).waitFor();
  };
  const setting = (page, name) => page.locator(`tr[data-name=${name}]`);
  const board = async (url) => (await fetch(`${url}api/board`)).json();
  const held = async (url, name) => (await board(url)).settings.find((one) => one.name === name).value;

  return {
    async "an axis is homed, and what prevents it is told"(url) {
      const driven = await driver(url);
      assert.equal(await homes(driven), 50);
      assert.equal((await rests(url)).state, "ready");
      assert.deepEqual(driven.faults.filter((one) => !one.includes("409")), []);
      await driven.context.close();
    },

    async "a page that is closed homes nothing"(url) {
      const { page, card, context } = await open(url);
      await controls(page);
      await card.locator("summary").click();
      await fill(card, "seek", 50);
      await fill(card, "slow", 20);
      await fill(card, "back-off", 4000);
      await fill(card, "within", 90_000);
      await click(card, "home");
      await moves(url);
      await context.close();
      const one = await rests(url);
      assert.equal(one.home.stage, "failed");
      assert.match(one.home.words, /gone/);
    },

    async "settings are boxes to tick where they are no numbers, in groups"(url) {
      const { page, context } = await open(url);
      await controls(page);
      await view(page, "settings");
      assert.deepEqual(await page.locator(".settings .group").allTextContents(), ["How a step is made", "Drivers", "Motion", "Limit switches", "Soft limits", "What stops a motor"]);
      const { settings } = await board(url);
      assert.equal(await page.locator("tr[data-name]").count(), settings.length);
      const reverse = setting(page, "reverse");
      await reverse.getByLabel("axis 3").check();
      await until("it is set", async () => (await held(url, "reverse")) === 4);
      await reverse.getByLabel("axis 1").check();
      await until("both are set", async () => (await held(url, "reverse")) === 5);
      await setting(page, "enable-high").getByLabel("on").check();
      await until("it is on", async () => (await held(url, "enable-high")) === 1);
      await setting(page, "estop").locator("select").selectOption("high");
      await until("it is high", async () => (await held(url, "estop")) === 2);
      await setting(page, "estop").getByText("changed", { exact: true }).waitFor();
      for (const name of ["reverse", "enable-high", "estop"]) await page.getByRole("button", { name: `Reset ${name}` }).click();
      for (const name of ["reverse", "enable-high", "estop"]) await until(`${name} is reset`, async () => (await held(url, name)) === 0);
      await setting(page, "reverse").getByText("changed", { exact: true }).waitFor({ state: "hidden" });
      assert.equal(await reverse.locator("input:checked").count(), 0);
      await context.close();
    },

    async "the sliders change the speed and the acceleration on the way"(url) {
      const { page, card, faults, context } = await open(url);
      await controls(page);
      await fill(card, "speed", 500);
      await click(card, "run-ahead");
      await until("it is at 500", async () => Math.abs((await axis(url)).speed - 500) < 50);
      await card.locator("[name=accel-slide]").fill("600");
      await card.locator("[name=speed-slide]").fill("600");
      const top = Number(await card.locator("[name=speed]").inputValue());
      assert.equal(await card.locator("[name=speed-slide]").getAttribute("aria-valuetext"), `${top}`);
      assert.ok(top > 700, `${top}`);
      await until("it is faster", async () => Math.abs((await axis(url)).speed - top) < 0.1 * top);
      const accel = Math.round(Number(await card.locator("[name=accel]").inputValue()));
      assert.ok(accel > 5000, `${accel}`);
      assert.match(await page.locator("#lines").innerText(), new RegExp(`a${accel}\\*`));
      await page.keyboard.press("Space");
      await rests(url);
      // A typed number moves its slider.
      await fill(card, "speed", 10);
      await card.locator("[name=speed]").press("Tab");
      assert.equal(await card.locator("[name=speed-slide]").inputValue(), "0");
      assert.deepEqual(faults, []);
      await context.close();
    },

    async "settings are set and reset, and what is wrong is told in its place"(url) {
      const { page, context } = await open(url);
      await controls(page);
      await view(page, "settings");
      const pulse = setting(page, "pulse-us");
      assert.equal(await pulse.locator("input").inputValue(), "2");
      assert.match(await pulse.innerText(), /1 to 20 µs[\s\S]*STEP stays high/);
      await pulse.locator("input").fill("7");
      await pulse.getByRole("button", { name: "Set pulse-us", exact: true }).click();
      await pulse.getByText("changed", { exact: true }).waitFor();
      assert.equal(await held(url, "pulse-us"), 7);
      for (const wrong of ["21", "-1", "2.5", "x"]) {
        await pulse.locator("input").fill(wrong);
        await pulse.locator("input").press("Enter");
        await pulse.getByText("Allowed: 1 to 20 µs").waitFor();
      }
      assert.equal(await held(url, "pulse-us"), 7);
      // While a motor moves the board refuses, which is shown there.
      await view(page, "control");
      await page.locator(".axis").first().locator("[name=run-ahead]").click();
      await moves(url);
      await view(page, "settings");
      await pulse.locator("input").fill("3");
      await pulse.locator("input").press("Enter");
      await pulse.getByText("settings change while every axis rests").waitFor();
      // Here only the space bar affects a motor.
      await page.locator("h1").click();
      await page.keyboard.press("ArrowLeft");
      await page.keyboard.press("Space");
      await rests(url);
      // Another page shows it too; text being typed here stays.
      const other = await open(url);
      await view(other.page, "settings");
      assert.equal(await setting(other.page, "pulse-us").locator("input").inputValue(), "7");
      assert.ok(await setting(other.page, "pulse-us").getByRole("button", { name: "Reset pulse-us" }).isDisabled());
      await pulse.getByRole("button", { name: "Reset pulse-us" }).click();
      await until("it is reset", async () => (await held(url, "pulse-us")) === 2);
      await until("the other page sees it", async () => (await setting(other.page, "pulse-us").locator("input").inputValue()) === "2");
      await other.context.close();
      await page.getByRole("button", { name: "Reset all" }).click();
      await page.getByRole("button", { name: /Reset these/ }).click();
      await until("all are reset", async () => (await board(url)).settings.every((one) => one.value === one.default));
      await context.close();
    },

    async "a card's sliders and its jerk go by the settings of now"(url) {
      const { page, card, context } = await open(url);
      await controls(page);
      const set = async (name, act) => {
        await view(page, "settings");
        await act(setting(page, name));
        await setting(page, name).getByText("changed", { exact: true }).waitFor();
        await view(page, "control");
      };
      const type = (value) => async (row) => {
        await row.locator("input").fill(String(value));
        await row.locator("input").press("Enter");
      };
      await fill(card, "jerk", 5000);
      await set("max-speed", type(400));
      await set("max-accel", type(900));
      await set("law", (row) => row.getByLabel("on").uncheck());
      await until("jerk is not asked for", () => card.locator("[name=jerk]").isHidden());
      for (const [name, most] of [["speed", "400"], ["accel", "900"]]) {
        await card.locator(`[name=${name}-slide]`).fill("1000");
        assert.equal(await card.locator(`[name=${name}]`).inputValue(), most);
      }
      // A jerk from before is not sent.
      const { position } = await axis(url);
      await fill(card, "target", 20);
      await click(card, "by");
      await until("it moves", async () => (await axis(url)).position !== position);
      await rests(url);
      assert.deepEqual(await page.locator("#notices p:not(#errors)").allInnerTexts(), []);
      await view(page, "settings");
      for (const name of ["max-speed", "max-accel", "law"]) {
        await page.getByRole("button", { name: `Reset ${name}` }).click();
        await setting(page, name).getByText("changed", { exact: true }).waitFor({ state: "hidden" });
      }
      await view(page, "control");
      await until("jerk is asked for again", () => card.locator("[name=jerk]").isVisible());
      await card.locator("[name=speed-slide]").fill("1000");
      assert.ok(Number(await card.locator("[name=speed]").inputValue()) > 10_000);
      await context.close();
    },

    async "each unit of the plots has a scale and a name"() {
      const place = mkdtempSync(join(tmpdir(), "stepwright-units-"));
      const file = join(place, "two.toml");
      writeFileSync(file, `${MACHINE}[axis.2]\nsteps-per-rev = 200\n`);
      const { child, said: url } = await start("page ", "serve", "--machine", file, "--virtual", "--bind", "127.0.0.1:0");
      const { page, card, faults, context } = await open(url);
      await controls(page);
      const titles = await page.locator(".u-title").allInnerTexts();
      assert.equal(titles[0], "Position in mm (axis 1), right in deg (axis 2), right in steps (axis 3)");
      assert.equal(titles[2], "Acceleration in mm/s² (axis 1), right in deg/s² (axis 2), right in steps/s² (axis 3)");
      await fill(card, "target", 0.2);
      await click(card, "to");
      const second = page.locator(".axis").nth(1);
      await fill(second, "target", 1000);
      await click(second, "to");
      await rests(url, 2);
      await until("both fill their scales", () => page.evaluate(() => {
        const { mm, deg } = document.getElementById("charts").plots.plots[0].scales;
        return mm.max > 0.2 && mm.max < 0.3 && mm.min > -0.1 && deg.max > 1000 && deg.max < 1200;
      }));
      // Speeds of 0 are at one height.
      assert.deepEqual(await page.evaluate(() => {
        const { scales } = document.getElementById("charts").plots.plots[1];
        return ["mm", "deg", "steps"].map((unit) => scales[unit].min + scales[unit].max);
      }), [0, 0, 0]);
      // One number alone on an axis tells no scale.
      await page.setViewportSize({ width: 1280, height: 800 });
      await page.reload();
      await controls(page);
      await fill(card, "target", 0);
      await click(card, "to");
      await moves(url);
      await rests(url);
      const labels = await page.evaluate(() => document.getElementById("charts").plots.plots.map(({ axes }) => axes.slice(1).map((one) => one._values.filter(Boolean).length)));
      assert.ok(labels.flat().every((count) => count >= 2), JSON.stringify(labels));
      // What the board would refuse is told at its field, in the field's unit.
      await fill(card, "speed", 1e5);
      await click(card, "by");
      const speed = card.locator("[name=speed]");
      assert.match(await speed.evaluate((one) => one.validationMessage), /2500/);
      assert.equal(await page.locator("#notices p").count(), 0);
      await fill(card, "speed", 2);
      // A long number has room at its axis, and no two labels are the same.
      const [room, needed, names] = await page.evaluate(async () => {
        const { chartAxis } = await import("./colours.js");
        const pen = document.createElement("canvas").getContext("2d");
        pen.font = '12px system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, "Noto Sans", sans-serif';
        const axis = chartAxis(" s");
        return [axis.size(null, ["-2147483647"]), pen.measureText("-2147483647").width + 15, axis.values(null, [86400.05, 86400.1], 0, 0, 0.05)];
      });
      assert.ok(room >= needed, `${room} ${needed}`);
      assert.deepEqual(names, ["86400.05 s", "86400.1 s"]);
      assert.deepEqual(faults, []);
      await context.close();
      await end(child);
      rmSync(place, { recursive: true });
    },

    async "the values of all three plots at the pointer are told, each with its unit"(url) {
      const { page, card, at, context } = await driver(url);
      const from = await at();
      await fill(card, "speed", 1000);
      await fill(card, "accel", 10_000);
      await fill(card, "target", 2000);
      await click(card, "by");
      await moves(url);
      await rests(url);
      const { left, top, time } = await page.evaluate(() => {
        const { plots, axes } = document.getElementById("charts").plots;
        const time = axes[0].plans.at(-1).begin + 1;
        const { left, top } = plots[0].over.getBoundingClientRect();
        return { left: left + plots[0].valToPos(time, "x"), top: top + 20, time };
      });
      await page.locator("#pause").click();
      await page.mouse.move(left + 2, top);
      await page.mouse.move(left, top);
      const told = async (label) => {
        const row = page.locator("#charts .u-legend .u-series", { has: page.getByText(label, { exact: true }) });
        const text = await row.locator(".u-value").innerText();
        const values = /^(-?[\d.]{1,9}) steps, (-?[\d.]{1,8}) steps\/s, (-?[\d.]{1,9}) steps\/s²$/.exec(text);
        assert.ok(values, text);
        return values.slice(1).map(Number);
      };
      for (const label of ["1 planned", "axis 1"]) {
        const [place, speed] = await told(label);
        // After a second, to a few pixels.
        assert.ok(Math.abs(place - from - 950) < 80, `${label} ${place} ${from} ${time}`);
        assert.ok(Math.abs(speed - 1000) < 30, `${label} ${speed}`);
      }
      await context.close();
    },

    async "a calculator computes what the command does, and says what is missing"(url) {
      const { page, context } = await open(url);
      await view(page, "calc");
      // An example is computed already, without the words of a command.
      await page.getByText("A belt of 2 mm pitch on a pulley of 20").waitFor();
      assert.match(await page.locator(".result").innerText(), /40 mm/);
      assert.equal(await page.locator("#calc code").textContent(), "stepwright calc belt --teeth 20");
      await page.fill("[name='--teeth']", "");
      await page.getByText("Needed: teeth").waitFor();
      await page.fill("[name='--teeth']", "x");
      await page.getByText("invalid value 'x' for 'teeth'").waitFor();
      for (const name of ["timer", "timed", "range", "belt", "screw", "delay", "vref", "microstep"]) {
        await page.locator("#calc select").first().selectOption(name);
        await until(`${name} has an answer`, () => page.locator(".result h3").count());
        assert.doesNotMatch(await page.locator("#calc .calc").innerText(), /--[a-z]/, name);
      }
      await page.locator("#calc select").first().selectOption("vref");
      await page.fill("[name='CURRENT']", "1.7A 600mA");
      await page.locator("[name='--driver']").selectOption("a4988");
      await until("it is computed", async () => /A4988/.test(await page.locator(".result").innerText()));
      await context.close();
    },

    async "a recording of hours has every time as it was"(url) {
      const pin = (name, level, ...edges) => ({ name, axis: null, pin: "enable", level, edges });
      const signals = [pin("a", false, 1, 2 ** 32 + 6), pin("b", null, 9e12 + 3)];
      const record = { source: "pins", words: "ns", hz: 1_000_000_000, begin: 0, end: 1e13, signals };
      const asked = { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(record) };
      const file = await (await fetch(`${url}api/scope/file?ending=mcap`, asked)).arrayBuffer();
      assert.deepEqual(await recorded(Buffer.from(file)), {
        "/a": [[0, 0], [1, 1], [2 ** 32 + 7, 0]],
        "/b": [[9e12 + 3, 1]],
      });
    },

    async "the scope shows each edge, and gives what it shows as files"(url) {
      const { page, card, faults, context } = await open(url);
      await controls(page);
      await fill(card, "speed", 1000);
      await fill(card, "accel", 100_000);
      await fill(card, "target", 400);
      await click(card, "by");
      await moves(url);
      await rests(url);
      await view(page, "scope");
      await page.getByText("the edges of the virtual board's pins").waitFor();
      await page.locator("#scope-span").selectOption("10");
      await until("it is shown", async () => (await page.locator("#scope-hold").textContent()) === "Hold");
      await new Promise((later) => setTimeout(later, 800));
      await page.locator("#scope-hold").click();
      const lanes = page.locator("#scope-lanes");
      const box = await lanes.boundingBox();
      await lanes.click({ position: { x: 80, y: 20 } });
      await lanes.click({ position: { x: box.width - 4, y: 20 } });
      const said = await page.locator("#scope-cursors").textContent();
      const rising = Number(/axis 1: (\d+)/.exec(said)[1]);
      const seconds = Number(/between ([\d.]+) s · ([\d.]+) Hz/.exec(said)[1]);
      assert.ok(Math.abs(Number(/axis 1 at ([\d.]+) steps\/s/.exec(said)[1]) - rising / seconds) < 0.1, said);
      // The lanes fill the window, down to the buttons.
      assert.ok(box.height > 400, `${box.height}`);
      // The files have the same steps as the cursors count, and as the board has made.
      const saved = async (name) => {
        const [file] = await Promise.all([page.waitForEvent("download"), page.locator(`#scope-${name}`).click()]);
        return readFileSync(await file.path());
      };
      const vcd = String(await saved("vcd"));
      const letter = /\$var wire 1 (\S) step1 /.exec(vcd)[1];
      const rises = vcd.split("$end\n").at(-1).split("\n").filter((one) => one === `1${letter}`).length;
      assert.ok(rises >= 400, `${rises}`);
      const rows = String(await saved("csv")).trim().split("\n").map((row) => row.split(","));
      const column = rows[0].indexOf("step1");
      const ups = rows.slice(2).filter((row, n) => row[column] === "1" && rows[n + 1][column] === "0");
      assert.equal(ups.length, rises);
      // The recording has the edges of the table, of every pin.
      const all = Object.entries(await recorded(await saved("mcap")));
      const topics = Object.fromEntries(all.filter(([topic]) => !topic.startsWith("/axis")));
      assert.deepEqual(Object.keys(topics), rows[0].slice(1).map((name) => `/${name}`));
      for (const [place, topic] of Object.keys(topics).entries()) {
        const levels = rows.slice(1).map((row) => [Math.floor(Number(row[0]) * 1000), row[place + 1]]);
        const changes = levels.filter(([, level], n) => level !== "" && level !== levels[n - 1]?.[1]);
        assert.deepEqual(topics[topic], changes.map(([nanos, level]) => [nanos, Number(level)]), topic);
      }
      assert.equal(topics["/step1"].filter(([, level]) => level).length, rises);
      // At 1000 steps/s, between the ramps, two steps are a millisecond apart.
      const times = ups.map((row) => Number(row[0]));
      const [from, to] = [...said.matchAll(/[AB] ([\d.]+) (µs|ms|s)/g)].map(([, n, unit]) => n * { µs: 1, ms: 1e3, s: 1e6 }[unit]);
      const between = times.filter((time) => time >= from && time < to).length;
      assert.ok(between >= 400 && Math.abs(between - rising) <= 1, `${between}: ${said}`);
      const level = times.slice(-200, -100).map((time, n, all) => (n ? time - all[n - 1] : 1000));
      assert.ok(level.every((one) => Math.abs(one - 1000) < 1), `${level}`);
      // The server gives the same.
      const ours = await (await fetch(`${url}api/scope.csv?seconds=10`)).text();
      assert.ok(ours.startsWith(rows[0].join()));
      const theirs = await recorded(Buffer.from(await (await fetch(`${url}api/scope.mcap?seconds=10`)).arrayBuffer()));
      const pins = Object.keys(theirs).filter((topic) => !topic.startsWith("/axis"));
      assert.deepEqual(pins, Object.keys(topics));
      assert.ok("/axis1" in theirs, Object.keys(theirs).join());
      assert.ok(theirs["/step1"].filter(([, level]) => level).length >= 400);
      // These keys look around in the view, and move nothing.
      await lanes.focus();
      for (const key of ["+", "ArrowRight", "ArrowLeft", "-", "0"]) await page.keyboard.press(key);
      assert.equal((await axis(url)).moving, false);
      // Both cursors by keys alone, each on its edge.
      for (const key of ["+", "a", "ArrowRight", "b"]) await page.keyboard.press(key);
      const [a, b] = await page.locator("#scope-cursors").textContent().then((text) => [...text.matchAll(/[AB] ([\d.]+)/g)].map(([, time]) => Number(time)));
      assert.ok(a > 0 && b > a, `${a} ${b}`);
      assert.deepEqual(faults, []);
      await context.close();
    },

    async "a motor on coils has a lane for each, and its steps are counted"() {
      const { child, said: url } = await start("page ", "serve", "--virtual", "--bind", "127.0.0.1:0", "--machine", "none", "--drive", "1:bridge-half");
      const { page, card, faults, context } = await open(url);
      await controls(page);
      await fill(card, "speed", 500);
      await fill(card, "target", 37);
      await click(card, "by");
      await until("it is there", async () => (await axis(url)).position === 37);
      await fill(card, "target", -10);
      await click(card, "by");
      await until("it is back", async () => (await axis(url)).position === 27);
      await rests(url);
      await view(page, "scope");
      await page.locator("#scope-span").selectOption("10");
      await new Promise((later) => setTimeout(later, 900));
      await page.locator("#scope-hold").click();
      const lanes = page.locator("#scope-lanes");
      const box = await lanes.boundingBox();
      await lanes.click({ position: { x: 66, y: 20 } });
      await lanes.click({ position: { x: box.width - 2, y: 20 } });
      assert.match(await page.locator("#scope-cursors").textContent(), /steps of axis 1: 47, axis 2: 0, axis 3: 0/);
      const [file] = await Promise.all([page.waitForEvent("download"), page.locator("#scope-csv").click()]);
      const rows = readFileSync(await file.path(), "utf8").trim().split("\n").map((row) => row.split(","));
      assert.deepEqual(rows[0], ["time_us", ..."abcd".split("").map((line) => `coil1${line}`), "step2", "dir2", "step3", "dir3", "enable"]);
      // The rows of the bridge's half steps, In1 to In4: 37 forward, 10 back.
      const half = ["0101", "0001", "1001", "1000", "1010", "0010", "0110", "0100"];
      const seen = rows.slice(1).map((row) => row.slice(1, 5).join("")).filter((row, n, all) => row !== all[n - 1]);
      const places = Array.from({ length: 48 }, (_, n) => (n <= 37 ? n : 74 - n));
      assert.deepEqual(seen, places.map((place) => half[place % 8]));
      assert.deepEqual(faults, []);
      await context.close();
      await end(child);
    },
  };
}

const MACHINE = `[axis.1]
steps-per-rev = 3200
mm-per-rev = 8
top-speed = "40mm/s"
accel = "200mm/s2"
home-speed = "10mm/s"
home-slow = "1mm/s"
home-within = "250mm"
`;

/** Pictures of these views, light and dark, wide and narrow, with the helpers of drive.mjs. */
export async function pictures({ start, end, open, controls, until, rests, axis, click, fill, folder }) {
  const place = mkdtempSync(join(tmpdir(), "stepwright-views-"));
  const file = join(place, "mill.toml");
  writeFileSync(file, MACHINE);
  for (const colorScheme of ["light", "dark"]) {
    for (const [size, viewport, more] of [
      ["wide", { width: 1440, height: 1000 }, {}],
      ["phone", { width: 390, height: 844 }, { isMobile: true, hasTouch: true }],
    ]) {
      const options = ["--virtual", "--switch", "1:-300", "--bind", "127.0.0.1:0"];
      const { child, said: url } = await start("page ", "serve", "--machine", file, ...options);
      const { page, card, context } = await open(url, { viewport, colorScheme, ...more });
      await controls(page);
      const view = (name) => page.click(`nav a[href="#${name}"]`);
      const setting = (name) => page.locator(`tr[data-name=${name}]`);
      const shot = async (name) => {
        await page.evaluate(() => scrollTo(0, 0));
        await page.screenshot({ path: join(folder, `${name}-${size}-${colorScheme}.png`) });
      };
      await view("settings");
      await setting("switches").getByLabel("axis 1").check();
      await page.fill("#set-idle-ms", "60000");
      await page.press("#set-idle-ms", "Enter");
      for (const name of ["switches", "idle-ms"]) {
        await setting(name).getByText("changed", { exact: true }).waitFor();
      }
      await page.fill("#set-pulse-us", "21");
      await page.press("#set-pulse-us", "Enter");
      await page.getByText("Allowed: 1 to 20 µs").waitFor();
      await shot("settings");
      await view("control");
      await card.locator("summary").click();
      await fill(card, "seek", 2);
      await click(card, "home");
      await until("it approaches", async () => (await axis(url)).home?.stage === "approach");
      await shot("home");
      await until("it is homed", async () => (await axis(url)).home?.stage === "done");
      await fill(card, "speed", 5);
      await fill(card, "accel", 100);
      const [second, third] = [1, 2].map((n) => page.locator(".axis").nth(n));
      for (const [other, speed, by] of [[second, 3, 5], [third, 7, 12]]) {
        await fill(other, "speed", speed);
        await fill(other, "accel", 60);
        await fill(other, "target", by);
        await click(other, "by");
      }
      await fill(card, "target", -0.06);
      await click(card, "by");
      await rests(url);
      await fill(card, "target", 0.5);
      await click(card, "by");
      for (const n of [1, 2, 3]) await rests(url, n);
      await view("scope");
      await page.locator("#scope-span").selectOption("10");
      await new Promise((later) => setTimeout(later, 900));
      await page.locator("#scope-hold").click();
      // Around the turn of axis 1, until single pulses are visible.
      const lanes = page.locator("#scope-lanes");
      const { width } = await lanes.boundingBox();
      const [dumped] = await Promise.all([page.waitForEvent("download"), page.locator("#scope-vcd").click()]);
      const dump = readFileSync(await dumped.path(), "utf8").split("$enddefinitions");
      const dir = /\$var wire 1 (\S) dir1 /.exec(dump[0])[1];
      let [time, turned] = [0, 0];
      for (const line of dump[1].split("$end\n").at(-1).split("\n")) {
        if (line.startsWith("#")) time = Number(line.slice(1));
        if (line.slice(1) === dir) turned = time;
      }
      const turn = turned / time;
      const x = 64 + (width - 64) * turn;
      await lanes.click({ position: { x, y: 45 } });
      for (let n = 0; n < 8; n++) await page.locator("#scope-in").click();
      await lanes.click({ position: { x: width * 0.8, y: 45 } });
      await shot("scope");
      await view("calc");
      await page.fill("[name='--teeth']", "20");
      await page.fill("[name='--speed']", "60mm/s");
      await page.getByText("pulley of 20").waitFor();
      await shot("calc");
      await context.close();
      await end(child);
    }
  }
  rmSync(place, { recursive: true });
  await coils({ start, end, open, controls, until, axis, click, fill, folder });
}

/** Half steps of a motor on bridges, where it turns round. */
async function coils({ start, end, open, controls, until, axis, click, fill, folder }) {
  const { child, said: url } = await start("page ", "serve", "--machine", "none", "--virtual", "--bind", "127.0.0.1:0", "--drive", "1:bridge-half");
  for (const [name, viewport, colorScheme] of [
    ["wide-light", { width: 1440, height: 1000 }, "light"],
    ["phone-dark", { width: 390, height: 844 }, "dark"],
  ]) {
    const { page, card, context } = await open(url, { viewport, colorScheme });
    await controls(page);
    const from = (await axis(url)).position;
    await fill(card, "speed", 400);
    for (const by of [24, -12]) {
      await fill(card, "target", by);
      await click(card, "by");
      const there = by > 0 ? from + 24 : from + 12;
      await until("it is there", async () => (await axis(url)).position === there && !(await axis(url)).moving);
    }
    await page.click('nav a[href="#scope"]');
    await page.locator("#scope-span").selectOption("2");
    await new Promise((later) => setTimeout(later, 900));
    await page.locator("#scope-hold").click();
    const lanes = page.locator("#scope-lanes");
    const { width } = await lanes.boundingBox();
    await lanes.click({ position: { x: 70, y: 45 } });
    await lanes.click({ position: { x: width - 6, y: 45 } });
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ path: join(folder, `coils-${name}.png`) });
    await page.locator("#release").click();
    await context.close();
  }
  await end(child);
}
