// The page: what is shown, who controls, and the keys.

import { Axis } from "./axis.js";
import { by, element, looked, once } from "./dom.js";
import { PathsView } from "./paths.js";
import { PlanView } from "./plan.js";
import { Plots } from "./plots.js";
import { lineForm } from "./line.js";
import { GONE, follow, get, hand, post, release, take } from "./server.js";
import { Scope } from "./scope.js";
import { Settings } from "./settings.js";
import * as talk from "./talk.js";

const plots = new Plots();
const settings = new Settings(by("settings"));
new Scope(tell);
// A page without a server never shows them.
const calculators = once(async () => new (await import("./calc.js")).Calculators(by("calc"), tell));
looked("#calc", () => calculators().catch(tell));
const plan = new PlanView(tell);
const paths = new PathsView(tell);
let axes = [];
let sheet = -1;
let ours = false;
/** A new page takes control if nobody has it, for this time in ms. */
let comes = 0;
const COMES = 3000;
/** A failed description of the board is asked for again after this, in ms. */
const AGAIN = 1000;
let asking = false;
let chosen = null;
let moving = false;
/** Whether the board can be reached, and the stop's words. */
let reached = true;
const STOPS = by("stop-words").textContent;

/** A notice with a button, which calls `act(notice)`. */
function noticed(text, word, act) {
  const notice = element("p", element("span", text));
  notice.append(element("button", word, { onclick: () => act(notice) }));
  return notice;
}

/** The notice with this text. */
const noticeOf = (text) => [...by("notices").children].find((notice) => notice.firstChild.textContent === text);

/** Shows an error until it is dismissed; the same one once. */
function tell(error) {
  // A file of the page that did not come.
  const text = (!reached && error instanceof TypeError ? GONE : error).message ?? error;
  const notices = by("notices");
  if (noticeOf(text)) return;
  notices.append(noticed(text, "Dismiss", (notice) => notice.remove()));
  // Errors to acknowledge stay.
  while (notices.children.length > 4) notices.querySelector("p:not(#errors)").remove();
}

const attempt = (promise) => promise.catch(tell);

/** Shows another board, or other settings. */
async function describe(count) {
  sheet = count;
  const board = await get("/api/board");
  if (count !== sheet) return;
  board.set = Object.fromEntries(board.settings.map(({ name, value }) => [name, value]));
  plan.board(board);
  by("board").textContent = board.name;
  document.title = `${board.name} – Stepwright`;
  settings.describe(board);
  const same = axes.length === board.axes.length &&
    axes.every((axis, i) => axis.scale === board.axes[i].steps_per_unit && axis.unit === board.axes[i].unit);
  if (!same) {
    axes = board.axes.map((one) => new Axis(one, tell));
    lineForm(axes, tell);
    by("axes").replaceChildren(...axes.map((axis) => axis.card));
    choose(axes[0]);
    plots.describe(board.axes);
  }
  axes.forEach((axis) => axis.describe(board));
}

/** The axis of the arrow keys. */
function choose(axis) {
  chosen = axis;
  axes.forEach((one) => one.card.classList.toggle("chosen", one === axis && axes.length > 1));
}
by("axes").addEventListener("focusin", (event) => {
  const axis = axes.find((one) => one.card.contains(event.target));
  if (axis) choose(axis);
});

let trouble = null;
let errors = "";

function show(state) {
  if (!comes && sheet === -1) comes = performance.now() + COMES;
  if (state.sheet !== sheet) describe(state.sheet).catch((error) => (tell(error), setTimeout(() => (sheet = -1), AGAIN)));
  const had = ours;
  ours = state.control !== null && state.control.hand === hand;
  if (had && !ours && state.control) tell(`${state.control.name} has taken control: you watch now`);
  for (const one of state.axes) axes.find((axis) => axis.number === one.axis)?.show(one, ours);
  settings.allow(ours && state.connected);
  moving = state.axes.some((axis) => axis.moving);
  by("line").querySelector("button").disabled = !ours || !state.connected || moving;
  moving ||= paths.running;
  showControl(state.control, state.connected);
  reach(state.connected);
  const now = state.trouble?.what ?? null;
  if (now && now !== trouble) tell(`${state.trouble.what}. ${state.trouble.do ?? ""}`);
  trouble = now;
  showErrors(state);
  plots.see(state);
  plan.state(state, ours);
  paths.allow(ours);
}

/** Shows whether the board can be reached: a stop that reaches nobody must not look like one. */
function reach(on) {
  if (on === reached) return;
  reached = on;
  by("board").classList.toggle("lost", !on);
  document.body.classList.toggle("unreached", !on);
  by("stop-words").textContent = on ? STOPS : "No answer: switch off the motor's power";
  by("frozen").hidden = on;
  if (!on) return;
  noticeOf(GONE.message)?.remove();
  // The open view asks again for what did not come.
  dispatchEvent(new Event("hashchange"));
}

function showControl(control, connected) {
  const who = by("who");
  const words = ours ? "You control" : control ? `${control.name} controls, you watch` : "Nobody controls";
  if (who.textContent !== words) who.textContent = words;
  by("release").hidden = !ours;
  by("take").hidden = ours;
  by("take").textContent = control?.live ? "Take over" : "Take control";
  by("take").disabled = !connected;
  // The first page takes control, and so does one that is reloaded.
  if (!asking && !control?.live && connected && performance.now() < comes) {
    asking = true;
    take(false).then(() => (comes = 0), () => {}).finally(() => (asking = false));
  }
}

/** Shows errors since the last acknowledgement. */
function showErrors(state) {
  const words = state.errors.map((error) => error.words);
  if (state.late) words.push(`${state.late} late steps`);
  const now = words.join(", ");
  if (now === errors) return;
  errors = now;
  by("notices").querySelector("#errors")?.remove();
  if (!now) return;
  const acknowledge = () => attempt(post("/api/acknowledge"));
  const notice = noticed(`Since the last acknowledgement: ${now}`, "Acknowledge", acknowledge);
  notice.id = "errors";
  by("notices").prepend(notice);
}

const live = follow(
  (message) => {
    if (message.type === "state") show(message);
    else if (message.type === "line") talk.line(message);
    else if (message.type === "plan") plots.plan(message);
    else if (message.type === "unplanned") plots.unplan(message.axis, message.time);
    else if (message.type === "path") paths.hear(message);
    else if (message.type === "note") talk.note(message);
  },
  () => {
    reach(false);
    plots.lose();
    ours = false;
    by("who").textContent = "The server does not answer";
    paths.lost();
    axes.forEach((axis) => axis.show({ position: null, moving: false, state: "lost", stop: null, home: null }, false));
    sheet = -1;
    comes = 0;
  },
);

const frame = () => {
  plots.draw();
  requestAnimationFrame(frame);
};
requestAnimationFrame(frame);

const stop = () => attempt(post("/api/stop"));
by("stop").addEventListener("pointerdown", (event) => event.button === 0 && stop());
// Enter, and assistive tools: a click without a pointer.
by("stop").onclick = (event) => event.detail === 0 && stop();
by("take").onclick = () => attempt(take(true));
by("release").onclick = () => attempt(release());
by("questions").onchange = (event) => live.questions(event.target.checked);
by("clear").onclick = talk.clear;
by("span").onchange = (event) => {
  plots.span = Number(event.target.value);
  plots.draw(true);
};
const showPause = () => {
  const on = plots.paused !== null;
  Object.assign(by("pause"), { ariaPressed: on, textContent: on ? "Go on" : "Pause" });
};
plots.onpause = showPause;
by("pause").onclick = () => {
  plots.pause(plots.paused === null);
  showPause();
};

/** How long a kill is held, in ms. */
const HELD = 600;
const kill = () => attempt(post("/api/kill"));
let pressed = null;
const press = () => {
  if (pressed) return;
  by("kill").classList.add("held");
  pressed = setTimeout(() => (letGo(), kill()), HELD);
};
const letGo = () => {
  clearTimeout(pressed);
  pressed = null;
  by("kill").classList.remove("held");
};
by("kill").addEventListener("pointerdown", (event) => event.button === 0 && press());
for (const end of ["pointerup", "pointerleave", "pointercancel", "blur"]) by("kill").addEventListener(end, letGo);
by("kill").addEventListener("contextmenu", (event) => event.preventDefault());
by("kill").addEventListener("keydown", (event) => event.key === "Enter" && press());
by("kill").addEventListener("keyup", (event) => event.key === "Enter" && letGo());

// Keys. The space bar stops wherever the focus is.
addEventListener("keydown", (event) => {
  const text = event.target.matches("textarea");
  if (event.key === " " && (!text || moving)) {
    // It ticks boxes too, but presses no button. In a text it is a space while motors rest.
    if (!event.target.matches("[type=checkbox], select")) event.preventDefault();
    if (!event.repeat) stop();
    return;
  }
  if (text) return;
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("input, select")) return;
  if (event.key === "K" && event.shiftKey && !event.repeat) {
    kill();
    return;
  }
  // Invisible axes are not moved.
  if (!by("axes").clientWidth) return;
  const sign = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (sign && chosen) {
    event.preventDefault();
    if (!event.repeat) chosen.hold(sign);
  }
  const axis = axes.find((one) => String(one.number) === event.key);
  if (axis) {
    choose(axis);
    axis.card.focus();
  }
}, { capture: true });
addEventListener("keyup", (event) => {
  if (event.key === " " && !event.target.matches("[type=checkbox], textarea")) event.preventDefault();
  if (event.key.startsWith("Arrow")) axes.forEach((axis) => axis.letGo());
}, { capture: true });
// A key released elsewhere is not heard here.
for (const end of ["blur", "pagehide"]) addEventListener(end, () => axes.forEach((axis) => axis.letGo()));
document.addEventListener("visibilitychange", () => document.hidden && axes.forEach((axis) => axis.letGo()));

// A comma is a decimal point, which a number's field would drop: 1,5 would be 15.
addEventListener("beforeinput", (event) => {
  if (event.target.type !== "number" || !event.data?.includes(",")) return;
  event.preventDefault();
  document.execCommand("insertText", false, event.data.replaceAll(",", "."));
});

// Views: control, plots and line are side by side if there is room; `full` views
// always have the page to themselves.
const view = () => {
  const sections = [...document.querySelectorAll("main > section")];
  const shown = sections.find((one) => location.hash === `#${one.id}`) ?? sections[0];
  for (const one of sections) one.classList.toggle("shown", one === shown);
  document.body.classList.toggle("alone", shown.classList.contains("full"));
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash !== `#${shown.id}`) {
      link.removeAttribute("aria-current");
      continue;
    }
    link.setAttribute("aria-current", "page");
    link.scrollIntoView({ block: "nearest", inline: "center" });
  }
  plots.resize();
};
addEventListener("hashchange", view);
view();
