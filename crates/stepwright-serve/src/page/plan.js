// The Plan view: a travel by every law, before anything moves.

import { by, choose, copy, digits, element, looked, once } from "./dom.js";
import { refusals } from "./plan-board.js";
import { PlanCharts } from "./plan-charts.js";
import { command, rust } from "./plan-copy.js";
import { LAWS, NUMBERS, Planner } from "./planner.js";
import { post } from "./server.js";

/** Each law in words, and its own numbers. */
const ABOUT = {
  trapezoid: ["Trapezoid", "Constant acceleration up to the top speed, and constant deceleration. A controller plans it.", ["start"]],
  "s-curve": ["S-curve", "The acceleration comes and goes at a limited jerk: gentle to what hangs on the motor. A controller plans it.", ["jerk", "start"]],
  austin: ["Austin", "Each delay from the one before, with one division a step (Eq 12 to 19).", ["c0", "divisor"]],
  "austin-fixed": ["Austin’s listing", "The same as it was published: fixed point, delay for delay. It brakes as it speeds up.", []],
  "linear-factor": ["Linear factor", "Austin’s recommended transition: from the knee on the acceleration falls to 0 at the top speed.", ["knee", "c0"]],
  power: ["Power term", "A power of the step number ends the acceleration; the approach is asymptotic.", ["power", "c0"]],
  piecewise: ["Piecewise", "The acceleration is reduced in stages near the top speed.", ["breaks", "c0"]],
};

/** Numbers on sliders: name, unit, from, to, kind and step. */
const SLIDERS = {
  steps: ["Steps", "", 1, 1e6, "whole"],
  top: ["Top speed", "steps/s", 1, 2e5],
  accel: ["Acceleration", "steps/s²", 1, 1e7],
  decel: ["Deceleration", "steps/s²", 1, 1e7],
  start: ["Start speed", "steps/s", 0, 5000, "square"],
  jerk: ["Jerk", "steps/s³", 10, 1e10],
  knee: ["Knee", "of the top", 0, 0.9, "even", 0.01],
  power: ["Power", "", 2, 9, "even", 1],
  breaks: ["Breaks", "", 0, 8, "even", 1],
};

/** Numbers with choices. */
const CHOICES = {
  rate: ["Timer", [[1e5, "100 kHz"], [1e6, "1 MHz"], [2e6, "2 MHz"], [16e6, "16 MHz"], [84e6, "84 MHz"], [2e8, "200 MHz"]]],
  c0: ["First delay", [[0, "exact (Eq 7)"], [1, "0.676 of it (Eq 15)"], [2, "exact, then 0.4056"]]],
  divisor: ["Divisor", [[0, "4n + 1"], [1, "2n"]]],
};

/** The places of a slider. */
const PLACES = 1000;

export class PlanView {
  /** `tell(error)` shows refusals. */
  constructor(tell) {
    this.tell = tell;
    this.travel = {
      rate: 16e6, steps: 1000, start: 0, top: 1000, accel: 2000, decel: 2000, jerk: 20000,
      c0: 1, divisor: 0, knee: 0, power: 4, breaks: 7,
    };
    this.law = 0;
    this.shown = new Set([0, 1, 4]);
    this.zoom = null;
    this.plans = [];
    this.sheet = null;
    this.place = new Map();
    this.ours = false;
    this.fields = {};
    for (const name of ["rate", "steps", "top", "accel", "decel"]) by("travel-values").append(this.control(name));
    for (const name of ["start", "jerk", "divisor", "c0", "knee", "power", "breaks"]) by("law-values").append(this.control(name));
    by("plan").view = this;
    this.table();
    this.listen();
    this.choose(0);
  }

  /** Opens at the first look. */
  open = once(async () => {
    const answer = await fetch("./plan.wasm");
    this.planner = await Planner.open(await answer.arrayBuffer());
    const all = (kind) => [...document.querySelectorAll(`#plan ${kind}`)];
    this.charts = new PlanCharts(all(".place"), all(".at"), (from, to) => this.zoomTo(from, to));
    this.plan();
  });

  /** A row with a number, and a slider or choices. */
  control(name) {
    const choice = CHOICES[name];
    const [title, unit, low, high, kind, step] = choice ?? SLIDERS[name];
    const row = element("label", element("span", title, "name"), "slider");
    row.dataset.name = name;
    if (choice) {
      const select = element("select", choice[1].map(([value, words]) => new Option(words, value)));
      row.append(select);
      this.fields[name] = { show: (value) => (select.value = value) };
      select.oninput = () => this.set(name, Number(select.value));
      return row;
    }
    const exact = element("input", [], { type: "number", step: "any", min: low, required: true, ariaLabel: title });
    const slide = element("input", [], { type: "range", min: 0, max: PLACES, ariaLabel: `${title}, slider` });
    row.append(element("span", [exact, element("i", unit)], "number"), slide);
    const part = {
      even: [(v) => (v - low) / (high - low), (p) => low + p * (high - low)],
      square: [(v) => Math.sqrt(v / high), (p) => high * p * p],
    }[kind] ?? [(v) => Math.log(v / low) / Math.log(high / low), (p) => low * (high / low) ** p];
    const rounded = (value) => {
      if (step) return Number((Math.round(value / step) * step).toFixed(3));
      const near = Number(value.toPrecision(value >= 100 ? 3 : 2));
      return kind === "whole" || near >= 10 ? Math.round(near) : near;
    };
    this.fields[name] = {
      show: (value, from) => {
        if (from !== exact) exact.value = value;
        if (from !== slide) slide.value = Math.round(part[0](Math.min(Math.max(value, low), high)) * PLACES);
        slide.ariaValueText = `${value} ${unit}`;
      },
    };
    slide.oninput = () => this.set(name, rounded(part[1](slide.value / PLACES)), slide);
    exact.oninput = () => this.set(name, exact.valueAsNumber, exact);
    return row;
  }

  /** Sets a number: its curves follow at once. */
  set(name, value, from) {
    this.travel[name] = value;
    this.fields[name].show(value, from);
    if (by("alike").checked && (name === "accel" || name === "decel")) {
      const twin = name === "accel" ? "decel" : "accel";
      this.travel[twin] = value;
      this.fields[twin].show(value);
    }
    this.zoom = null;
    this.plan();
  }

  table() {
    const rows = LAWS.map((name, law) => {
      const [title] = ABOUT[name];
      const box = element("input", [], { type: "checkbox", ariaLabel: `Show ${title}`, checked: this.shown.has(law) });
      box.oninput = () => {
        if (box.checked) this.shown.add(law);
        else this.shown.delete(law);
        this.plan();
      };
      const button = element("button", title, { onclick: () => this.choose(law) });
      const row = element("tr", element("td", element("span", [box, button], "pick")));
      row.style.setProperty("--own", `var(--law-${law})`);
      return row;
    });
    by("laws").tBodies[0].append(...rows);
  }

  /** Chooses the law that is changed and stands out. */
  choose(law) {
    this.law = law;
    this.shown.add(law);
    const name = LAWS[law];
    const [title, words, own] = ABOUT[name];
    by("law-name").textContent = title;
    by("law-words").textContent = words;
    for (const row of by("law-values").children) row.hidden = !own.includes(row.dataset.name);
    const { rows } = by("laws").tBodies[0];
    choose(rows, law);
    rows[law].querySelector("input").checked = true;
    by("copied").hidden = true;
    this.plan();
  }

  zoomTo(from, to) {
    this.zoom = from === undefined ? null : [Math.max(0, from), to];
    this.plan();
  }

  /** Plans and draws the shown laws: the chosen one at once, then the others, those
   *  first that were planned longest ago. */
  plan() {
    for (const [name, field] of Object.entries(this.fields)) if (!this.planner) field.show(this.travel[name]);
    if (!this.planner) return;
    const [from, to] = this.zoom ?? [0, 1e12];
    this.asked = NUMBERS.map((name) => ({ from, to, ...this.travel })[name]);
    this.plans = LAWS.map((_, law) => (this.shown.has(law) ? this.plans[law] : null));
    this.planOne(this.law);
    const others = [...this.shown].filter((law) => law !== this.law);
    this.waiting = others.sort((a, b) => (this.plans[a]?.turn ?? 0) - (this.plans[b]?.turn ?? 0));
    this.draw();
    if (this.waiting.length) this.later ??= setTimeout(() => this.planOthers());
  }

  planOne(law) {
    this.turn = (this.turn ?? 0) + 1;
    this.plans[law] = { ...this.planner.plan(law, this.asked), turn: this.turn };
  }

  /** Plans laws that wait, for a part of a frame. */
  planOthers() {
    this.later = null;
    const end = performance.now() + 5;
    while (this.waiting.length && performance.now() < end) this.planOne(this.waiting.shift());
    this.draw();
    if (this.waiting.length) this.later = setTimeout(() => this.planOthers());
  }

  draw() {
    const longest = Math.max(0, ...this.plans.map((plan) => plan?.figures?.seconds ?? 0));
    this.charts.show(this.plans, this.law, this.zoom ?? [0, longest || 1]);
    this.figures();
    this.ask();
  }

  figures() {
    const unit = (ticks) => `${digits(ticks, 3)} ticks`;
    [...by("laws").tBodies[0].rows].forEach((row, law) => {
      const plan = this.plans[law];
      while (row.cells.length > 1) row.deleteCell(1);
      row.classList.toggle("hidden", !plan);
      if (plan?.refused) {
        const cell = row.insertCell();
        cell.colSpan = 6;
        cell.className = "no";
        cell.textContent = `${plan.refused.what}: ${plan.refused.remedy}`;
        return;
      }
      const f = plan?.figures;
      const lost = f && f.seconds > 0 ? (f.lost / (f.seconds - f.lost)) * 100 : 0;
      const cells = f
        ? [
            `${digits(f.seconds, 5)} s`,
            Math.abs(lost) < 0.005 ? "0 %" : `${lost > 0 ? "+" : "−"}${digits(Math.abs(lost), 3)} %`,
            digits(f.peak, 5),
            `${f.brakingSteps} in ${digits(f.brakingSeconds, 3)} s`,
            unit(f.error),
            f.deviationRms < 0.005 ? "0 %" : `${digits(f.deviationRms, 3)} %`,
          ]
        : ["–", "–", "–", "–", "–", "–"];
      for (const text of cells) row.insertCell().textContent = text;
      if (f) {
        const micros = digits((f.error / this.travel.rate) * 1e6, 3);
        row.cells[5].title = `${micros} µs, at step ${f.errorStep}`;
        row.cells[6].title = `at most ${digits(f.deviation, 3)} %, at step ${f.deviationStep}`;
      }
    });
  }

  /** The board, as in GET /api/board. */
  board(sheet) {
    this.sheet = sheet;
    const select = by("plan-axis").querySelector("select");
    const kept = select.value;
    select.replaceChildren(...sheet.axes.map(({ axis }) => new Option(axis, axis)));
    if (kept && kept <= sheet.axes.length) select.value = kept;
    by("plan-axis").hidden = sheet.axes.length < 2;
    this.ask();
  }

  /** The board's state; `ours` if this page controls. */
  state(state, ours) {
    const before = `${this.ours} ${this.connected} ${[...this.place.values()].map((axis) => `${axis.moving} ${axis.position}`)}`;
    this.ours = ours;
    this.connected = state.connected;
    for (const axis of state.axes) this.place.set(axis.axis, axis);
    const now = `${ours} ${state.connected} ${state.axes.map((axis) => `${axis.moving} ${axis.position}`)}`;
    if (before !== now && by("plan").classList.contains("shown")) this.ask();
  }

  get axis() {
    return Number(by("plan-axis").querySelector("select").value || 1);
  }

  /** Says what the board would refuse, and whether it can be sent. */
  ask() {
    const plan = this.plans[this.law];
    const name = LAWS[this.law];
    const copies = !plan?.refused && plan;
    for (const id of ["copy-command", "copy-rust"]) by(id).disabled = !copies;
    const place = this.place.get(this.axis);
    let words = "There is no board here: copy it, and move a motor by it.";
    let reasons = [];
    let able = false;
    if (this.sheet && copies) {
      reasons = refusals(name, this.travel, plan.figures.peak, this.sheet, this.axis, place);
      const axis = this.sheet.axes.find((one) => one.axis === this.axis);
      const way = axis && axis.unit !== "steps" ? ` It is ${digits(this.travel.steps / axis.steps_per_unit, 5)} ${axis.unit}.` : "";
      const board = this.sheet.name.replace(/^the /, "The ");
      words = reasons.length ? `${board} would refuse it:` : `${board} takes it.${way}`;
      able = !reasons.length && this.ours && this.connected && place && !place.moving && place.position !== null;
      if (!reasons.length && !able) {
        words += !this.ours ? " To send it, take control." : place?.moving ? " The axis is moving." : " It is not ready.";
      }
    } else if (this.sheet) words = "There is no such travel.";
    if (by("plan-board").textContent !== words) by("plan-board").textContent = words;
    const list = by("reasons");
    if (reasons.join("\n") !== this.reasons) {
      this.reasons = reasons.join("\n");
      list.replaceChildren(...reasons.map((reason) => element("li", reason)));
    }
    by("send").hidden = !this.sheet;
    by("send").disabled = !able;
  }

  send() {
    const { steps, top, start, accel, decel, jerk } = this.travel;
    const order = { axis: this.axis, by: steps, top_speed: top, start_speed: start, accel, decel };
    post("/api/move", LAWS[this.law] === "s-curve" ? { ...order, jerk } : order).catch(this.tell);
  }

  listen() {
    by("alike").oninput = () => by("alike").checked && this.set("decel", this.travel.accel);
    by("third").oninput = (event) => this.charts?.third(event.target.value);
    by("send").onclick = () => this.send();
    by("plan-axis").oninput = () => this.ask();
    by("copy-command").onclick = () => {
      const { name = "virtual", port = name } = this.sheet ?? {};
      copy(command(LAWS[this.law], this.travel, port.includes("virtual") ? null : port, this.axis), by("copied"));
    };
    by("copy-rust").onclick = () =>
      copy(rust(LAWS[this.law], this.travel, this.plans[this.law].figures), by("copied"));
    for (const id of ["travel", "own"]) by(id).onsubmit = (event) => event.preventDefault();
    looked("#plan", () => this.open().then(() => this.charts.resize(), this.tell));
  }
}
