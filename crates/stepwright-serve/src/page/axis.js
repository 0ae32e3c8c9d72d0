// The card of one axis: its position, and buttons that move it.

import { by } from "./dom.js";
import { post } from "./server.js";

/** Three decimals, or three digits if those are finer: a step may be a small part of a unit. */
const most = { maximumFractionDigits: 3, maximumSignificantDigits: 3, roundingPriority: "morePrecision" };
const format = new Intl.NumberFormat("en", { ...most, useGrouping: false });
const words = { ready: "at rest", busy: "moving", uncertain: "position uncertain", lost: "no board" };

/** The default speed, in steps/s, and the time up to it, in s. */
const SPEED = 1000;
const RISE = 0.4;

/** The sliders' ranges, in steps/s and steps/s², if no board tells others. */
const SLIDES = { speed: [10, 20_000], accel: [100, 1_000_000] };

/** The longest travel, in steps. */
export const FAR = 2 ** 31 - 1;

/** Defaults of a homing, in steps/s and steps. Only the user knows how far the switch may be. */
const HOMING = { seek: 500, slow: 50, "back-off": 50 };
const ASKED = [...Object.keys(HOMING), "within"];

export class Axis {
  /** `sheet` as in GET /api/board; `tell(error)` shows refusals. */
  constructor(sheet, tell) {
    this.number = sheet.axis;
    this.scale = sheet.steps_per_unit;
    this.tell = tell;
    this.moving = false;
    this.homing = false;
    this.holding = null;
    this.card = by("axis").content.firstElementChild.cloneNode(true);
    this.card.style.setProperty("--own", `var(--axis-${((sheet.axis - 1) % 3) + 1})`);
    this.find("h2").textContent = `Axis ${sheet.axis}`;
    this.card.ariaLabel = `Axis ${sheet.axis}`;
    const label = (selector, text) => this.card.querySelectorAll(selector).forEach((one) => (one.textContent = text));
    label(".unit", sheet.unit);
    [1, 2, 3].forEach((n) => label(`.per${n}`, `${sheet.unit}/s${["", "²", "³"][n - 1]}`));
    this.unit = sheet.unit;
    this.field("speed").value = this.shown(SPEED);
    this.field("accel").value = this.shown(SPEED / RISE);
    this.field("step").value = this.shown(100);
    for (const [name, steps] of Object.entries(HOMING)) this.field(name).value = this.shown(steps);
    if (sheet.home_within) this.field("within").value = this.shown(sheet.home_within);
    for (const name of ["target", "step", "back-off", "within"]) this.field(name).max = this.shown(FAR);
    this.field("target").min = this.shown(-FAR);
    /** Changes that were not sent yet, by the names of requests. */
    this.changes = new Map();
    this.listen();
  }

  /** What the board can do by its settings. */
  describe({ can, max_speed, set }) {
    const jerk = can.includes("jerk") && set.law !== 0;
    this.find(".motion").classList.toggle("straight", !jerk);
    // Hidden fields are not sent.
    if (!jerk) this.field("jerk").value = "";
    this.slide("speed", "top_speed", max_speed ?? SLIDES.speed[1], set["max-speed"]);
    this.slide("accel", "accel", SLIDES.accel[1], set["max-accel"]);
    // What no travel may have, in the field's own unit.
    const ends = { speed: [0.001, set["max-speed"] ?? 1e6], accel: [1, set["max-accel"] ?? 1e8], jerk: [0, 4e9] };
    for (const [name, [min, max]] of Object.entries(ends)) Object.assign(this.field(name), { min: this.shown(min), max: this.shown(max) });
  }

  find(selector) {
    return this.card.querySelector(selector);
  }

  field(name) {
    return this.find(`[name=${name}]`);
  }

  /** Steps as a number in the axis' unit. */
  shown(steps) {
    return format.format(steps / this.scale);
  }

  /** A number in the axis' unit as steps. */
  steps(name) {
    return this.field(name).valueAsNumber * this.scale;
  }

  /** The motion, as in requests. */
  motion() {
    const jerk = this.steps("jerk");
    return { accel: this.steps("accel"), ...(jerk > 0 && { jerk }) };
  }

  /** Whether the values of these fields can be sent. */
  valid(...names) {
    return names.every((name) => this.field(name).reportValidity());
  }

  /** Sends a request about this axis. */
  send(path, body) {
    return post(path, { axis: this.number, ...body }).catch(this.tell);
  }

  /** To a position or by a distance; a moving axis gets another target. */
  go(way) {
    if (!this.valid("speed", "accel", "jerk")) return;
    const top_speed = this.steps("speed");
    if (!this.moving) {
      this.send("/api/move", { ...way, top_speed, ...this.motion() });
    } else if ("to" in way) {
      this.send("/api/retarget", { ...way, top_speed, accel: this.steps("accel") });
    }
  }

  /** A slider beside a number, on a log scale. Changes hold at once, also on
   *  the way. */
  slide(name, as, most, allowed = most) {
    const high = Math.min(most, allowed);
    const low = Math.min(SLIDES[name][0], high / 10);
    const [field, slider] = [this.field(name), this.field(`${name}-slide`)];
    const say = () => (slider.ariaValueText = field.value);
    const follow = () => {
      slider.value = (1000 * Math.log(this.steps(name) / low)) / Math.log(high / low);
      say();
    };
    slider.oninput = () => {
      field.value = this.shown(Number((low * (high / low) ** (slider.value / 1000)).toPrecision(3)));
      say();
      this.change(name, as);
    };
    field.onchange = () => (follow(), this.change(name, as));
    follow();
  }

  /** Sends changes to a moving motor: one order at a time, with the newest values. */
  async change(name, as) {
    if (!this.moving || this.homing || !this.valid(name)) return;
    this.changes.set(as, name);
    if (this.changing) return;
    this.changing = true;
    while (this.changes.size) {
      const body = Object.fromEntries([...this.changes].map(([as, name]) => [as, this.steps(name)]));
      this.changes.clear();
      await this.send("/api/retarget", body);
    }
    this.changing = false;
  }

  run(sign) {
    if (!this.valid("speed", "accel", "jerk")) return Promise.resolve(null);
    return this.send("/api/run", { speed: sign * this.steps("speed"), ...this.motion() });
  }

  stop() {
    return this.send("/api/stop", {});
  }

  /** Finds 0 by the limit switch. */
  home() {
    // An error is seen only in an open list.
    if (!ASKED.every((name) => this.field(name).validity.valid)) this.find(".homing").open = true;
    if (!this.valid(...ASKED)) return;
    const whole = (name) => Math.round(this.steps(name));
    const [back_off, within] = [whole("back-off"), whole("within")];
    this.send("/api/home", { speed: this.steps("seek"), slow: this.steps("slow"), back_off, within });
  }

  /** Runs while it is held. If it is released before the run was answered, the stop
   *  is sent behind it. */
  hold(sign) {
    if (this.holding || this.moving || this.field("ahead").disabled) return;
    this.field(sign > 0 ? "ahead" : "back").classList.add("held");
    this.holding = this.run(sign);
  }

  letGo() {
    if (!this.holding) return;
    const begun = this.holding;
    this.holding = null;
    for (const name of ["ahead", "back"]) this.field(name).classList.remove("held");
    // Also behind an order without an answer yet, for which a stop alone would not wait.
    this.stop();
    begun.then((taken) => taken && this.stop());
  }

  listen() {
    const on = (name, act) => (this.field(name).onclick = act);
    this.find(".go").addEventListener("submit", (event) => {
      event.preventDefault();
      this.go({ to: Math.round(this.steps("target")) });
    });
    const go = (name, sign) => this.valid(name) && this.go({ by: sign * Math.round(this.steps(name)) });
    on("by", () => go("target", 1));
    on("less", () => go("step", -1));
    on("more", () => go("step", 1));
    on("run-back", () => this.run(-1));
    on("run-ahead", () => this.run(1));
    on("stop-axis", () => this.stop());
    on("home", () => this.home());
    on("zero", () => this.send("/api/zero", {}));
    for (const [name, sign] of [["back", -1], ["ahead", 1]]) {
      const button = this.field(name);
      button.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        button.setPointerCapture(event.pointerId);
        this.hold(sign);
      });
      for (const end of ["pointerup", "pointercancel", "lostpointercapture", "contextmenu"]) {
        button.addEventListener(end, (event) => {
          if (end === "contextmenu") event.preventDefault();
          this.letGo();
        });
      }
      // Enter on the button, without a pointer.
      button.addEventListener("keydown", (event) => {
        if (event.key === "Enter") {
          event.preventDefault();
          if (!event.repeat) this.hold(sign);
        }
      });
      button.addEventListener("keyup", (event) => event.key === "Enter" && this.letGo());
      button.addEventListener("blur", () => this.letGo());
    }
  }

  /** Shows the axis' state; `ours` if this page controls. */
  show(state, ours) {
    this.moving = state.moving;
    this.position = state.position;
    const known = state.position !== null;
    this.find(".position").textContent = known ? this.shown(state.position) : "?";
    const speed = state.moving && `${this.shown(Math.round(state.speed))} ${this.unit}/s`;
    const steps = this.unit !== "steps" && known && `${state.position} steps`;
    this.find(".speed").textContent = [speed, steps].filter(Boolean).join(" · ");
    const word = this.find(".state");
    if (word.textContent !== words[state.state]) {
      word.textContent = words[state.state];
      word.className = `state ${state.state}`;
    }
    const why = this.find(".why");
    this.showHome(state.home);
    const reasons = [];
    if (state.stop) reasons.push(`Stopped by ${state.stop.words}`);
    if (state.state === "uncertain") reasons.push("Where it stands is not known: Home or Set 0 here");
    why.hidden = !reasons.length || this.homing;
    if (why.textContent !== reasons.join(". ")) why.textContent = reasons.join(". ");
    const able = ours && state.state !== "lost";
    const free = able && !state.moving && !this.homing;
    const rests = free && known;
    const set = (name, on) => (this.field(name).disabled = !on);
    for (const name of ["by", "less", "more", "run-back", "run-ahead"]) set(name, rests);
    // A held button stays enabled: its release must be noticed.
    for (const name of ["back", "ahead"]) set(name, rests || this.holding !== null);
    set("to", able && known && !this.homing);
    set("home", free);
    set("zero", free);
    set("stop-axis", state.state !== "lost");
    this.field("to").textContent = state.moving && !this.homing ? "Retarget" : "Go to";
  }

  /** Shows the stage of a homing, or how it ended. */
  showHome(home) {
    const told = this.find(".home");
    this.homing = Boolean(home) && home.stage !== "done" && home.stage !== "failed";
    told.hidden = !home;
    if (!home) return;
    const failed = home.stage === "failed";
    const text = failed ? ["Not homed: " + home.words, home.do].filter(Boolean).join(". ") : home.words;
    if (told.textContent !== text) told.textContent = text;
    told.className = `home ${home.stage}`;
  }
}
