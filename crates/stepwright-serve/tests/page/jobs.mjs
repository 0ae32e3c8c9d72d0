// G-code jobs in the Paths view: dropped, drawn, timed, and run on the virtual board.
//
//   node jobs.mjs STEPWRIGHT CHROMIUM [FOLDER]
//
// FOLDER is one for pictures. Ends with 0 if all tests pass.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { browser, end, play, running, serve, start, stepwright, until } from "./common.mjs";
import { colours, ends, head, near, open, pace, report, rows, seek } from "./way.mjs";

const [folder] = process.argv.slice(4);
const EXAMPLES = "examples/gcode";

/** Drops a file on the view, as from a file manager. */
const drop = async (page, name, text) => {
  const data = await page.evaluateHandle(([name, text]) => {
    const data = new DataTransfer();
    data.items.add(new File([text], name));
    return data;
  }, [name, text]);
  await page.dispatchEvent("#paths", "drop", { dataTransfer: data });
  await page.locator(`#paths-file option:text-is("${name}")`).first().waitFor({ state: "attached" });
  await until(`${name} is drawn`, async () => (await page.locator("#paths[aria-busy]").count()) === 0);
};

/** The report of `stepwright gcode` on a job: the plan, or the run. */
const asked = (file, ...options) => {
  // From stdin: the text is the first option.
  const input = file === "-" ? options.shift() : "";
  const words = ["gcode", file, "--machine", "none", "--format", "json", ...options];
  const { stdout } = spawnSync(stepwright, words, { input });
  return JSON.parse(stdout);
};

const fact = async (page, name) => page.locator(`#paths-facts dt:text-is("${name}") + dd`).innerText();
const wrong = (page) => page.locator("#paths-wrong li");

/** A spiral there and back, of 100,000 lines. */
const LONG = ["F3000"].concat(Array.from({ length: 100_000 }, (_, n) => {
  const [angle, radius] = [n * 0.02, 20 + (n % 1000) * 0.05];
  return `G1 X${(radius * Math.cos(angle)).toFixed(3)} Y${(radius * Math.sin(angle)).toFixed(3)}`;
})).join("\n");

const tests = (url) => ({
  async "every example is dropped, drawn, timed, and played to its end"() {
    const { page, faults, context } = await open(url);
    const names = readdirSync(EXAMPLES);
    assert.ok(names.length > 0);
    for (const name of names) {
      const file = join(EXAMPLES, name);
      const [plan, run] = [asked(file, "--plan"), asked(file, "--fast")];
      // From elsewhere, so under another name than the page's example.
      await drop(page, `my ${name}`, readFileSync(file, "utf8"));
      assert.match(await fact(page, "Time"), new RegExp(`^${plan.seconds.toFixed(6)} s`));
      for (const { axis, from, to } of plan.rows) assert.match(await fact(page, axis), new RegExp(`^${from} to ${to} mm`));
      await until("it can be run", () => page.locator("#paths-go").isEnabled());
      assert.equal(await page.locator("#paths-go").textContent(), "Run on a virtual board");
      const begun = Date.now();
      await page.locator("#paths-go").click();
      await until("a part of it", async () => (await head(page)).time > plan.seconds / 3);
      assert.equal((await report(url)).state, "running");
      await ends(page, "done");
      assert.ok(Date.now() - begun > plan.seconds * 1000, "as long as it takes");
      assert.deepEqual((await report(url)).places, run.position_mm.map((place) => Math.round(place * 1e6)));
      assert.deepEqual((await head(page)).places, run.position_mm);
      const end = run.position_mm.map((place, n) => `${"XYZ"[n]} ${place.toFixed(2)}`.replace("-", "−")).join(", ");
      assert.match(await page.locator("#paths-at").innerText(), new RegExp(`^${run.seconds.toFixed(2)} s · ${end} mm`));
      await page.locator("#paths-state").getByText(`my ${name} was run to its end: ${run.seconds.toFixed(2)} s`).waitFor();
    }
    assert.deepEqual(faults, []);
    await context.close();
  },

  async "a job is drawn where it goes, coloured by its speed"() {
    const { page, faults, context } = await open(url);
    await drop(page, "badge.nc", readFileSync(join(EXAMPLES, "badge.nc"), "utf8"));
    const all = await rows(page);
    assert.equal(all.length, 17);
    assert.match(all[3], /^4 Line\s+45, 0\s+\S+ s\s+10$/);
    assert.match(all[4], /^5 Arc\s+50, 5\s+\S+ s\s+10$/);
    assert.match(all[16], /^17 Rapid\s+0, 0/);
    // The outline at 10 mm/s, the arc itself (45°), the corner that the arc cuts off, the middle of the
    // longest rapid move, which is the fastest, and nothing.
    const round = 45 + 5 * Math.SQRT1_2;
    const spots = [[25, 30], [round, 25 + 5 * Math.SQRT1_2], [49.5, 29.5], [16, 7.5], [27.1, 17.3]];
    const [line, arc, cut, rapid, inside] = await colours(page, spots);
    const peak = await page.evaluate(() => document.getElementById("paths").view.sheet.peak);
    const [fast, slow] = [await pace(page, 1), await pace(page, 10 / peak)];
    assert.ok(near(line, slow) && near(arc, slow) && near(rapid, fast), `${line} ${arc} ${rapid} ${slow} ${fast}`);
    assert.deepEqual(cut, inside);
    assert.ok(!near(cut, slow) && !near(cut, fast), `${cut}`);
    // A part, and a corner, lead to their lines.
    const marked = () => page.locator("#paths-text").evaluate((area) => area.value.slice(area.selectionStart, area.selectionEnd));
    await page.locator("#paths-legs button").nth(4).click();
    assert.equal(await marked(), "G3 X50 Y5 R5");
    await page.getByText("Corners that cost most").click();
    assert.match(await page.locator("#paths-corners dd").first().innerText(), /^0\.119 s, at rest$/);
    await page.getByRole("button", { name: "Line 19: 32, 15, 3" }).click();
    assert.equal(await marked(), "G0 Z3");
    // X over Z: the depth.
    await page.locator("#paths-y").selectOption({ label: "Z" });
    assert.match((await rows(page))[2], /^3 Line\s+5, −1/);
    await page.locator("#paths-copy").click();
    assert.equal(await page.locator("#paths-copied").innerText(), "stepwright gcode examples/gcode/badge.nc");
    assert.deepEqual(faults, []);
    await context.close();
  },

  async "a laser's power is the colour, and the path goes on at speed"() {
    const { page, faults, context } = await open(url);
    await page.locator("#paths-file").selectOption({ label: "triangle.toml" });
    assert.ok(await page.locator("#paths-laser").isHidden());
    // Steps of power by M3, by M4 with ramps at its ends, and a way without power.
    const text = "M3 S1000 G1 F1200 X20\nS250 X40\nM4 S500 G1 X40 Y20\nM5 X20 Y20\nG0 X0 Y0\n";
    await drop(page, "burn.nc", text);
    const spindle = asked("-", text, "--plan");
    assert.match(await fact(page, "Time"), new RegExp(`^${spindle.seconds.toFixed(6)} s`));
    const on = page.locator("#paths-laser-on");
    assert.ok((await on.isVisible()) && !(await on.isChecked()));
    await on.check();
    const laser = asked("-", text, "--plan", "--laser");
    assert.ok(laser.seconds < spindle.seconds - 0.01, "no rest for an S");
    await page.locator("#paths-facts").getByText(`${laser.seconds.toFixed(6)} s`).waitFor();
    assert.equal(await fact(page, "Laser on"), `${laser.laser_on_s.toFixed(3)} s, 60 mm`);
    assert.equal(await page.locator("#paths-most").textContent(), "full power");
    const spots = [[10, 0], [30, 0], [40, 10], [30, 20], [10, 10]];
    const [full, quarter, half, off, rapid] = await colours(page, spots);
    const paces = [await pace(page, 1), await pace(page, 0.25), await pace(page, 0.5)];
    assert.ok(near(full, paces[0]) && near(quarter, paces[1]) && near(half, paces[2]), `${full} ${quarter} ${half} ${paces}`);
    for (const pale of [off, rapid]) assert.ok(!paces.some((one) => near(one, pale)), `${pale}`);
    // M3 burns with full power at both ends, M4 does not; both are off at rest.
    const powers = await page.evaluate(() => {
      const { times, places, powers } = document.getElementById("paths").view.sheet;
      return times.map((time, n) => [places[0][n], places[1][n], powers[n]]);
    });
    const at = (x, y) => powers.filter((one) => one[0] === x && one[1] === y).map((one) => one[2]);
    assert.deepEqual([at(0, 0)[0], at(20, 0), at(20, 20)], [1, [1, 0.25], [0, 0]]);
    assert.ok(at(40, 20)[0] < 0.2 && at(40, 0).at(-1) < 0.2, `${at(40, 20)} ${at(40, 0)}`);
    await seek(page, 0.5);
    assert.match(await page.locator("#paths-at").innerText(), / · laser 100 %$/);
    // S of full power.
    await page.locator("#paths-laser-most").fill("500");
    await page.getByText("from S500 on, of S1000").waitFor();
    await page.locator("#paths-copy").click();
    assert.equal(await page.locator("#paths-copied").innerText(), "stepwright gcode burn.nc --laser --laser-max 500");
    // The file is as it was left, after another one was shown.
    const typed = `${await page.locator("#paths-text").inputValue()}(typed)\n`;
    await page.locator("#paths-text").fill(typed);
    await page.locator("#paths-file").selectOption({ label: "badge.nc" });
    await until("an example is shown", async () => !(await page.locator("#paths-laser-on").isChecked()));
    await page.locator("#paths-file").selectOption("own");
    await until("it is shown again", async () => (await page.locator("#paths-text").inputValue()) === typed);
    assert.ok(await page.locator("#paths-laser-on").isChecked());
    assert.equal(await page.locator("#paths-laser-most").inputValue(), "500");
    await page.locator("#paths-laser-most").fill("0");
    await wrong(page).getByText("laser is no S of full power").waitFor();
    await page.locator("#paths-laser-most").fill("1000");
    await until("it can be run", () => page.locator("#paths-go").isEnabled());
    await page.locator("#paths-laser-most").fill("");
    await wrong(page).getByText("S of full power is no number").waitFor();
    assert.ok(await page.locator("#paths-go").isDisabled());
    await page.locator("#paths-laser-most").fill("1000");
    // It is run as it is drawn.
    await until("it can be run", () => page.locator("#paths-go").isEnabled());
    await page.locator("#paths-go").click();
    await ends(page, "done");
    await page.locator("#paths-state").getByText(`burn.nc was run to its end: ${laser.seconds.toFixed(2)} s`).waitFor();
    assert.deepEqual((await head(page)).places, [0, 0, 0]);
    // One example has a laser; another has none.
    await page.locator("#paths-file").selectOption({ label: "engrave.nc" });
    await page.locator("#paths-facts").getByText("Laser on").waitFor();
    await page.locator("#paths-file").selectOption({ label: "badge.nc" });
    await until("there is none", async () => (await page.locator("#paths-least").textContent()) === "at rest");
    assert.ok(!(await on.isChecked()));
    assert.deepEqual(faults.filter((one) => !one.includes("422")), []);
    await context.close();
  },

  async "the first mistake is told with its line and column, and shown"() {
    const { page, faults, context } = await open(url);
    const text = "G21 G90\nG1 F600 X10\nG1 X5 F-1\nG5\n";
    await drop(page, "wrong.NC", text);
    await wrong(page).getByText("wrong.NC, line 3, column 7: error 4: F is negative: write 0 or more").waitFor();
    assert.equal(await wrong(page).count(), 1);
    assert.ok(await page.locator("#paths-go").isDisabled());
    const area = page.locator("#paths-text");
    assert.equal(await area.evaluate((one) => one.value.slice(one.selectionStart, one.selectionEnd)), "F-1");
    // The selection of a field without the focus is not seen: its line has another colour.
    const tinted = () => area.evaluate((one) => {
      const [at, top, high] = ["backgroundPositionY", "paddingTop", "lineHeight"].map((name) => parseFloat(getComputedStyle(one)[name]));
      return Math.round((at - top) / high);
    });
    assert.equal(await tinted(), 2);
    // The corrected file is drawn; then the next mistake is the first.
    await area.fill(text.replace("F-1", "F1"));
    await wrong(page).getByText("wrong.NC, line 4, column 1: error 20").waitFor();
    await area.fill(text.replace("F-1", "F100").replace("G5\n", ""));
    await page.locator("#paths-sum").getByText(/^2 parts/).waitFor();
    assert.equal(await wrong(page).count(), 0);
    assert.ok((await tinted()) < 0);
    // A job in which nothing moves has no speed.
    await drop(page, "none.nc", "G21\n");
    await page.locator("#paths-sum").getByText("Nothing moves in this file").waitFor();
    assert.equal(await page.locator("#paths-most").textContent(), "0 mm/s");
    // A cycle file is drawn as one again, with its own player.
    await page.locator("#paths-file").selectOption({ label: "triangle.toml" });
    await page.locator("#paths-sum").getByText("4 parts, 78.336 s").waitFor();
    assert.match(await page.locator("#paths-player").innerText(), /takes travels, no paths/);
    assert.equal(await page.locator("#paths-facts dt").count(), 0);
    assert.deepEqual(faults.filter((one) => !one.includes("422")), []);
    await context.close();
  },

  async "a job of 100,000 lines freezes nothing, runs, and brakes at a stop"() {
    const { page, faults, context } = await open(url);
    // The longest time between two frames.
    await page.evaluate(() => {
      let before = performance.now();
      globalThis.longest = 0;
      const look = (now) => ((globalThis.longest = Math.max(globalThis.longest, now - before)), (before = now), requestAnimationFrame(look));
      requestAnimationFrame(look);
    });
    await drop(page, "long.nc", LONG);
    await until("it is timed", async () => (await page.locator("#paths-facts dt").count()) > 3);
    assert.match(await fact(page, "Time"), /^1907\.\d{6} s \(31:47 min\)$/);
    assert.match(await fact(page, "Lines"), /^100000, /);
    console.log(`  100,000 lines: ${(await page.evaluate(() => globalThis.longest)).toFixed(0)} ms without a frame`);
    const sizes = await page.evaluate(() => {
      const { sheet } = document.getElementById("paths").view;
      return [sheet.times.length, sheet.rows.length, document.getElementById("paths-text").value.length];
    });
    assert.ok(sizes[0] <= 20_400 && sizes[1] <= 400 && sizes[2] < 10_000, `${sizes}`);
    assert.match((await rows(page))[0], /^Lines 2 to 251/);
    // A part shows its lines.
    await page.locator("#paths-legs button").nth(100).click();
    assert.match(await page.locator("#paths-long").textContent(), /^Lines 24942 to 25062 of 100001\./);
    await until("it can be run", () => page.locator("#paths-go").isEnabled());
    await page.locator("#paths-go").click();
    await until("it is on its way", async () => {
      const now = await report(url);
      return now?.name === "long.nc" && now.seconds > 1;
    });
    await page.locator("h1").click();
    await page.keyboard.press("Space");
    await ends(page, "stopped");
    const { places } = await report(url);
    assert.ok(Math.hypot(places[0], places[1]) > 20e6, `${places}`);
    assert.deepEqual((await head(page)).places, places.map((place) => place / 1e6));
    // A mistake far behind is shown at its line.
    await drop(page, "long wrong.nc", LONG.replace("\nG1", "\nG0").replace(/\n([^\n]*)$/, "\nG1 X1 Q\n$1"));
    await wrong(page).getByText("long wrong.nc, line 100001, column 7: error 2").waitFor();
    assert.match(await page.locator("#paths-text").inputValue(), /\nG1 X1 Q\n/);
    // A file that is longer than the server reads is not sent.
    await page.evaluate(() => document.getElementById("paths").view.read(new File([new Uint8Array(5e6)], "huge.nc")));
    await page.getByText("huge.nc is too long: at most 4 MB are drawn here").waitFor();
    assert.deepEqual(faults.filter((one) => !one.includes("422")), []);
    await context.close();
  },

  async "a held run is resumed after its page was loaded again"() {
    const { page, faults, context } = await open(url);
    await drop(page, "slow.nc", "G1 F300 X20\n");
    const hold = page.locator("#paths-hold");
    await until("it can be run", () => page.locator("#paths-go").isEnabled());
    await page.locator("#paths-go").click();
    await until("it runs", async () => (await report(url)).state === "running");
    await hold.click();
    await page.locator("#paths-state.held").waitFor();
    await page.reload();
    await page.locator("#paths-state.held").getByText("slow.nc is held").waitFor();
    await hold.getByText("Resume").click();
    await page.locator("#paths-state.running").getByText("slow.nc is running").waitFor();
    await page.locator("#stop").click();
    await ends(page, "stopped");
    assert.ok(await hold.isHidden());
    assert.deepEqual(faults, []);
    await context.close();
  },

  async "a board that plays streams is followed, held and resumed"() {
    const { child: board, said: port } = await start("pty ", "board", "--pty", "--program", "stream");
    const { child, said } = await serve("--virtual", "--stream", port);
    const { page, faults, context } = await open(said);
    await drop(page, "slant.nc", "G1 F3000 X120 Y-90\nM30\n");
    assert.equal(await page.locator("#paths-go").textContent(), `Run on ${port}`);
    assert.match(await page.locator("#paths-player").innerText(), /streamed\. Steps, speeds/);
    await page.locator("#paths-copy").click();
    assert.equal(await page.locator("#paths-copied").innerText(), `stepwright gcode slant.nc --port ${port}`);
    // A board may have an output for a laser: it is asked when the job is run.
    await page.locator("#paths-laser-on").check();
    await until("it can be run with a laser", () => page.locator("#paths-go").isEnabled());
    await page.locator("#paths-copy").click();
    assert.match(await page.locator("#paths-copied").innerText(), /gcode slant\.nc .*--laser/);
    await page.locator("#paths-laser-on").uncheck();
    const hold = page.locator("#paths-hold");
    assert.ok(await hold.isHidden());
    /** Whether the run came this far: a busy computer may keep the board short, which then brakes. */
    const comes = async (what, so) => {
      let now;
      await until(what, async () => (now = await report(said)) && (so(now) || now.state === "failed"));
      if (now.state === "failed") assert.match(now.trouble.what, /short of what comes next/);
      return now.state !== "failed";
    };
    const held = async () => {
      await until("it can be run", () => page.locator("#paths-go").isEnabled());
      await page.locator("#paths-go").click();
      if (!(await comes("a part of it", ({ state, seconds }) => state === "running" && seconds > 0.7))) return false;
      assert.equal(await hold.textContent(), "Hold");
      await hold.click({ timeout: 5_000 });
      if (!(await comes("a hold", ({ state }) => state === "held"))) return false;
      await page.locator("#paths-state.held").getByText("slant.nc is held").waitFor();
      assert.equal(await hold.textContent(), "Resume");
      // It stands, on its line.
      await new Promise((later) => setTimeout(later, 400));
      const { places } = await head(page);
      await new Promise((later) => setTimeout(later, 600));
      if ((await report(said)).state === "failed") return false;
      assert.deepEqual((await head(page)).places, places);
      assert.ok(places[0] > 20 && places[0] < 110 && Math.abs(places[0] * 0.75 + places[1]) < 0.04, `${places}`);
      await hold.click({ timeout: 5_000 });
      return comes("the end", ({ state }) => state === "done");
    };
    let again = 5;
    while (!(await held())) assert.ok(again--, "the board was always short");
    await ends(page, "done");
    assert.deepEqual((await head(page)).places, [120, -90, 0]);
    assert.ok(await hold.isHidden());
    if (folder) await page.screenshot({ path: join(folder, "job-streamed.png") });
    assert.deepEqual(faults, []);
    await context.close();
    await end(child);
    await end(board);
  },

  async "what the board can't do is drawn, and not run"() {
    const machine = join(mkdtempSync(join(tmpdir(), "stepwright-")), "fast.toml");
    writeFileSync(machine, '[axis.1]\nsteps-per-rev = 12800\nmm-per-rev = 40\ntop-speed = "500mm/s"\n');
    const { child, said } = await start("page ", "serve", "--machine", machine, "--bind", "127.0.0.1:0", "--virtual");
    const { page, faults, context } = await open(said);
    await drop(page, "fast.nc", "G0 X400\nG1 F60 Y1");
    await page.locator("#paths-refused").getByText("An Uno would refuse it: in line 1 X comes to").waitFor();
    assert.ok(await page.locator("#paths-go").isDisabled());
    assert.deepEqual(faults, []);
    await context.close();
    await end(child);
  },

  async "on a phone nothing of a job is cut off"() {
    const { page, context } = await open(url, { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true });
    await drop(page, "badge.nc", readFileSync(join(EXAMPLES, "badge.nc"), "utf8"));
    await page.getByText("Corners that cost most").click();
    const [wide, room] = await page.evaluate(() => [document.scrollingElement.scrollWidth, innerWidth]);
    assert.ok(wide <= room, `${wide} in ${room}`);
    await context.close();
  },
});

/** A job, wide and narrow. */
async function pictures() {
  mkdirSync(folder, { recursive: true });
  const { said: url } = await serve("--virtual");
  for (const [size, scheme] of [["wide", "light"], ["phone", "dark"]]) {
    const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
    const { page, context } = await open(url, { ...(size === "phone" ? phone : {}), colorScheme: scheme });
    await page.locator("#paths-file").selectOption({ label: "engrave.nc" });
    await page.locator("#paths-facts").getByText("Laser on").waitFor();
    await page.evaluate(() => new Promise((on) => requestAnimationFrame(() => requestAnimationFrame(on))));
    await page.screenshot({ path: join(folder, `job-laser-${size}-${scheme}.png`) });
    await drop(page, "badge.nc", readFileSync(join(EXAMPLES, "badge.nc"), "utf8"));
    await seek(page, 18.4);
    if (size === "wide") await page.locator("#paths-edit summary").click();
    await page.locator("h1").click();
    if (size === "phone") await page.evaluate(() => scrollTo(0, document.querySelector("#paths .right").offsetTop - 110));
    await page.evaluate(() => new Promise((on) => requestAnimationFrame(() => requestAnimationFrame(on))));
    await page.screenshot({ path: join(folder, `job-${size}-${scheme}.png`) });
    await context.close();
  }
}

let failed = 0;
const { said: url } = await serve("--virtual");
const free = () => until("control is free", async () => !(await (await fetch(`${url}api/state`)).json()).control?.live);
try {
  failed = await play(tests(url), free);
  if (folder) await pictures();
} finally {
  await browser.close();
  for (const child of running) child.kill("SIGKILL");
}
process.exitCode = failed ? 1 : 0;
