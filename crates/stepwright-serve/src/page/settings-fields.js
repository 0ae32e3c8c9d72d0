// The fields of settings: a number, a choice, or checkboxes. Each has its `input`, `parts` to
// show, and its `value` as a text; `help` is in the words of that field.

import { element } from "./dom.js";

/** One field: a number, which is sent once it is typed, or a choice. */
class One {
  constructor({ min, max, unit, help }, change) {
    this.typed = Boolean(unit);
    if (this.typed) this.input = element("input", [], { type: "text", inputMode: "numeric", autocomplete: "off" });
    else this.input = element("select", ["none", "low", "high"].map((word, n) => new Option(word, n)), { onchange: change });
    this.parts = [this.input, unit];
    this.range = this.typed ? `${min} to ${max} ${unit}` : "";
    this.help = this.typed ? help : help.replace(": 0 none; 1 ", ": low: ").replace("; 2 ", "; high: ");
  }

  get value() {
    return this.input.value.trim();
  }

  set value(number) {
    this.input.value = number;
  }

  allow(able) {
    this.input.disabled = !able;
  }
}

/** Checkboxes, sent at once: on or off, or a set of axes, the sum of 1, 2 and 4. */
class Boxes {
  constructor({ max, help }, change, axes) {
    const names = max === 1 ? ["on"] : Array.from({ length: Math.min(axes, 3) }, (_, n) => `axis ${n + 1}`);
    this.boxes = names.map(() => element("input", [], { type: "checkbox", onchange: change }));
    [this.input] = this.boxes;
    this.parts = this.boxes.map((box, n) => element("label", [box, ` ${names[n]}`], "tick"));
    this.range = "";
    this.help = help.replace("1: ", "on: ").replace(" 0: ", " off: ").replace(/: 1 X, .*/, "");
  }

  get value() {
    return String(this.boxes.reduce((sum, box, n) => sum + (box.checked << n), 0));
  }

  set value(number) {
    this.boxes.forEach((box, n) => (box.checked = (number >> n) & 1));
  }

  allow(able) {
    this.boxes.forEach((box) => (box.disabled = !able));
  }
}

/** The field of a setting; `change` is called for a change without Enter. */
export function fieldOf(sheet, change, axes) {
  const boxes = !sheet.unit && sheet.max !== 2;
  return new (boxes ? Boxes : One)(sheet, change, axes);
}

/** The groups, with their settings in order. */
const GROUPS = {
  "How a step is made": ["pulse-us", "setup-us", "hold-us", "reverse"],
  Drivers: ["enable-ms", "idle-ms", "enable-high", "driver-fault", "kill-off"],
  Motion: ["max-speed", "max-accel", "law"],
  "Limit switches": ["switches", "switch-forward", "switch-high", "debounce-ms", "home-first"],
  "Soft limits": ["soft-limits", "ahead-x", "behind-x", "ahead-y", "behind-y", "ahead-z", "behind-z"],
  "What stops a motor": ["timeout-ms", "estop", "safe-start"],
};

/** A board's settings by group: [title, sheets]; others come last. */
export function grouped(sheets) {
  const known = Object.values(GROUPS).flat();
  const more = sheets.map((one) => one.name).filter((name) => !known.includes(name));
  const named = (names) => names.flatMap((name) => sheets.find((one) => one.name === name) ?? []);
  const groups = Object.entries({ ...GROUPS, More: more }).map(([title, names]) => [title, named(names)]);
  return groups.filter(([, all]) => all.length);
}
