// What a person does with the card of an axis, for every link to the board: over a WebSocket to
// `stepwright serve`, over a serial port of the browser, or to the board in the page.
//
// `at()` tells, from the pins or the API, the position of the axis that the page shows at rest. It may
// or may not change when the page sets 0: only differences count then.

import assert from "node:assert/strict";

import { until, watched } from "./common.mjs";

export const fill = (card, name, value) => card.locator(`[name=${name}]`).fill(String(value));
export const click = (card, name) => card.locator(`[name=${name}]`).click();
export const shown = async (card) => (await card.locator(".position").textContent()).trim();
const shownSpeed = async (card) => parseFloat(await card.locator(".speed").textContent());
export const word = async (card) => (await card.locator(".state").textContent()).trim();
export const moves = (card) => until("it moves", async () => (await word(card)) === "moving");

/** The position at rest. */
export const rests = (card) => until("it rests", async () => (await word(card)) === "at rest" && shown(card));

/** Waits until it rests at this position. */
export const arrives = (card, place) => until(`${place} is shown`, async () => (await word(card)) === "at rest" && (await shown(card)) === String(place));

/** A page, and the card of its first axis. */
export async function open(url, options = {}, before) {
  const { context, page, faults } = await watched(url, { viewport: { width: 1360, height: 900 }, ...options }, before);
  const card = page.locator(".axis").first();
  await card.waitFor();
  return { context, page, card, faults };
}

/** A travel to a position, one by a distance, and another speed and target on the way. `speed()` is in
 *  steps/s. */
export async function travels({ page, card, at, speed = () => shownSpeed(card) }) {
  await fill(card, "speed", 2000);
  await fill(card, "accel", 20000);
  const from = (await at()) - Number(await shown(card));
  const there = async (place) => {
    await arrives(card, place);
    assert.equal((await at()) - from, place);
  };
  await fill(card, "target", 700);
  await click(card, "to");
  await there(700);
  await fill(card, "target", -200);
  await click(card, "by");
  await there(500);
  // The order was shown line by line, each with its meaning.
  const lines = await page.locator("#lines").innerText();
  // The field itself refuses what no axis can travel.
  const told = await page.locator("#notices p").count();
  for (const wrong of ["1e20", "-2147483649", ""]) {
    await fill(card, "target", wrong);
    await click(card, "by");
    assert.equal(await card.locator("[name=target]:invalid").count(), 1, wrong);
    await click(card, "to");
  }
  assert.equal(await page.locator("#notices p").count(), told);
  assert.match(lines, /G-200[\s\S]*travel by this many steps[\s\S]*accepted/);
  // A comma is a decimal point.
  await fill(card, "step", "");
  await card.locator("[name=step]").pressSequentially("1,5");
  assert.equal(await card.locator("[name=step]").inputValue(), "1.5");
  await fill(card, "target", 1_000_000);
  await click(card, "to");
  await moves(card);
  await fill(card, "speed", 3000);
  await card.locator("[name=speed]").press("Tab");
  await until("it is faster", async () => (await speed()) > 2500);
  await fill(card, "target", 0);
  await card.getByText("Retarget").click();
  await there(0);
}

/** Every way to brake; each keeps the position. */
export async function stops({ page, card, at }) {
  const from = (await at()) - Number(await shown(card));
  for (const stop of [
    () => page.locator("#stop").click(),
    () => page.keyboard.press("Space"),
    // Also from within a field, and from another button.
    () => card.locator("[name=target]").press("Space"),
    () => card.locator("[name=run-back]").press("Space"),
  ]) {
    await click(card, "run-ahead");
    await moves(card);
    await stop();
    const place = Number(await rests(card));
    await card.getByText("Stopped by a soft stop").waitFor();
    assert.equal((await at()) - from, place);
  }
}

/** A kill is held, and loses the position; then 0 is set. */
export async function kills({ page, card, at }) {
  await click(card, "run-ahead");
  await moves(card);
  // A touch by accident does nothing: it goes on for a second.
  const begun = Number(await shown(card));
  await page.locator("#kill").click();
  await until("it goes on", async () => Number(await shown(card)) > begun + 1000);
  await page.locator("#kill").hover();
  await page.mouse.down();
  await until("? is shown", async () => (await shown(card)) === "?");
  await page.mouse.up();
  await card.getByText("Where it stands is not known: Home or Set 0 here").waitFor();
  assert.ok(await card.locator("[name=to]").isDisabled());
  const stood = await at();
  await click(card, "zero");
  await until("0 is shown", async () => (await shown(card)) === "0");
  await page.getByRole("button", { name: "Acknowledge" }).click();
  await page.locator("#errors").waitFor({ state: "detached" });
  await fill(card, "target", 40);
  await click(card, "to");
  await arrives(card, 40);
  assert.equal((await at()) - stood, 40);
  // By the key it need not be held.
  await click(card, "run-back");
  await moves(card);
  // With Ctrl the key is the browser's.
  await page.keyboard.press("Control+Shift+K");
  await new Promise((later) => setTimeout(later, 200));
  assert.equal(await word(card), "moving");
  await page.keyboard.press("Shift+K");
  await until("? is shown", async () => (await shown(card)) === "?");
  await click(card, "zero");
  await until("0 is shown", async () => (await shown(card)) === "0");
}

/** A jog, with the pointer and by a key, a tap, and single steps. */
export async function jogs({ page, card, at }) {
  await fill(card, "speed", 800);
  await fill(card, "accel", 8000);
  const begun = Number(await shown(card));
  const from = (await at()) - begun;
  await card.locator("[name=ahead]").hover();
  await page.mouse.down();
  await until("it has gone far", async () => Number(await shown(card)) > begun + 300);
  await page.mouse.up();
  const up = Number(await rests(card));
  assert.equal((await at()) - from, up);
  await page.locator("h1").click();
  await page.keyboard.down("ArrowLeft");
  await until("it has come back", async () => Number(await shown(card)) < up - 300);
  await page.keyboard.up("ArrowLeft");
  await rests(card);
  // A tap is a short run, never an endless one.
  await page.keyboard.press("ArrowRight");
  await new Promise((later) => setTimeout(later, 400));
  const place = Number(await rests(card));
  await fill(card, "step", 25);
  await click(card, "more");
  await arrives(card, place + 25);
  assert.equal((await at()) - from, place + 25);
}

/** Settings that the view writes, and that are refused there. */
export async function sets({ page }) {
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
}

/** A line of axes 1 and 2, of which the second goes further; the third stays. */
export async function lines({ page, card }) {
  const [second, third] = [1, 2].map((n) => page.locator(".axis").nth(n));
  const form = page.locator("#line");
  const stays = await until("it says where it is", () => shown(third));
  const from = Number(await shown(card));
  await fill(second, "speed", 1500);
  await fill(second, "accel", 4000);
  await form.getByLabel("Axis 1").fill(String(from - 300));
  await form.getByLabel("Axis 2").fill("900");
  await form.getByRole("button").click();
  await moves(card);
  await moves(second);
  assert.ok(await form.getByRole("button").isDisabled());
  await arrives(card, from - 300);
  await arrives(second, 900);
  assert.equal(await shown(third), stays);
  // The speed is that of the axis that goes further.
  assert.match(await page.locator("#lines").innerText(), /^T150\*/m);
  // Axes that are at their targets are no line.
  await form.getByRole("button").click();
  await page.locator("#notices").getByText("no axis moves").waitFor();
  await page.getByRole("button", { name: "Dismiss" }).click();
  await form.getByLabel("Axis 1").fill("1e20");
  await form.getByRole("button").click();
  assert.equal(await form.locator("input:invalid").count(), 1);
}

/** Homing, which needs the board's switch setting; 0 is 50 steps from where the switch closes. */
export async function homes({ page, card, at }) {
  // Only the user knows how far the switch may be.
  await click(card, "home");
  assert.equal(await card.locator("[name=within]:invalid").count(), 1);
  assert.ok(await card.locator("[name=within]").isVisible());
  assert.equal(await page.locator("#notices p").count(), 0);
  await fill(card, "within", 100_000);
  await click(card, "home");
  await page.locator("#notices").getByText("knows of no limit switch of axis 1").waitFor();
  await page.getByRole("button", { name: "Dismiss" }).click();
  await page.click('nav a[href="#settings"]');
  const switches = page.locator("tr[data-name=switches]");
  await switches.getByLabel("axis 1").check();
  await switches.getByText("changed", { exact: true }).waitFor();
  await page.click('nav a[href="#control"]');
  await fill(card, "seek", 600);
  await fill(card, "slow", 300);
  await click(card, "home");
  await card.getByText("seeks its switch").waitFor();
  assert.ok(await card.locator("[name=to]").isDisabled());
  assert.ok(await card.locator("[name=home]").isDisabled());
  await card.getByText("homed: 0 is where its switch closes").waitFor();
  await arrives(card, 50);
  const place = await at();
  assert.equal(await page.locator("#errors").count(), 0);
  // A stop on the way ends it.
  await fill(card, "back-off", 2000);
  await click(card, "home");
  await card.getByText("backs off").waitFor();
  await page.keyboard.press("Space");
  await card.getByText("Not homed: stopped before 0 was found").waitFor();
  await rests(card);
  return place;
}
