// The machine of a page without a server: its axes' unit, and the steps per unit. The browser
// keeps it, and the settings show its form.

import { element } from "./dom.js";

const KEPT = "stepwright-machine";

/** The units, and their titles. */
const UNITS = { steps: "steps", mm: "millimetres", deg: "degrees" };

/** The values of an axis: title, minimum, maximum, default. All but the last are whole. */
const ASKED = {
  steps: ["Full steps of a turn", 1, 10_000, 200],
  micro: ["Microsteps", 1, 1024, 16],
  mm: ["mm of a turn", 0.001, 10_000, 8],
};

const right = (name, value) => {
  const [, from, to] = ASKED[name];
  return typeof value === "number" && value >= from && value <= to && (name === "mm" || Number.isInteger(value));
};

const usual = () => Object.fromEntries(Object.entries(ASKED).map(([name, asked]) => [name, asked[3]]));

/** Steps per unit of an axis with these values. */
function perUnit(unit, { steps, micro, mm }) {
  return { steps: 1, mm: (steps * micro) / mm, deg: (steps * micro) / 360 }[unit];
}

/** The kept machine: a unit, and axes. A damaged one counts as none. */
function kept() {
  try {
    const { unit, axes } = JSON.parse(localStorage.getItem(KEPT));
    const good = (axis) => Object.keys(ASKED).every((name) => right(name, axis[name]));
    if (Object.hasOwn(UNITS, unit) && axes.every(good)) return { unit, axes };
  } catch {
    // None is kept, or the browser keeps nothing.
  }
  return { unit: "steps", axes: [] };
}

export class Machine {
  constructor() {
    Object.assign(this, kept());
  }

  /** The unit of axis 1 …, and the steps per unit. */
  of(axis) {
    return { unit: this.unit, steps_per_unit: perUnit(this.unit, this.built(axis)) };
  }

  /** An axis' values. */
  built(axis) {
    return this.axes[axis - 1] ?? usual();
  }

  keep(unit, axes) {
    Object.assign(this, { unit, axes });
    try {
      localStorage.setItem(KEPT, JSON.stringify({ unit, axes }));
    } catch {
      // It lasts until the page is closed.
    }
  }
}

/** The form of a machine with this many axes; `change()` applies it, or returns why not. */
export function machineForm(machine, count, change) {
  const unit = element("select", Object.entries(UNITS).map(([name, title]) => new Option(title, name)), { name: "unit", value: machine.unit });
  const heads = ["Axis", ...Object.values(ASKED).map(([title]) => title), "It is"];
  const rows = Array.from({ length: count }, (_, n) => {
    const inputs = Object.entries(ASKED).map(([name, [title, min, max]]) => element("input", [], {
      type: "number", name: `${name}-${n + 1}`, min, max, step: name === "mm" ? "any" : 1, required: true,
      value: machine.built(n + 1)[name], ariaLabel: `Axis ${n + 1}: ${title}`,
    }));
    const is = element("td");
    const row = element("tr", [element("th", n + 1), ...inputs.map((input) => element("td", input)), is]);
    const built = () => Object.fromEntries(Object.keys(ASKED).map((name, at) => [name, inputs[at].valueAsNumber]));
    return { row, is, inputs, built };
  });
  const table = element("table", [element("tr", heads.map((title) => element("th", title))), ...rows.map(({ row }) => row)], "values");
  const wide = element("div", table, "wide");
  const said = element("p", [], { className: "soft", role: "status" });
  const show = () => {
    wide.hidden = unit.value === "steps";
    rows.forEach(({ is, inputs, built }, n) => {
      Object.keys(ASKED).forEach((name, at) => {
        const input = inputs[at];
        // Unneeded fields are disabled, and invalid values in them restored.
        input.disabled = wide.hidden || (name === "mm" && unit.value !== "mm");
        if (input.disabled && !right(name, input.valueAsNumber)) input.value = machine.built(n + 1)[name];
      });
      const steps = perUnit(unit.value, built());
      is.textContent = Number.isFinite(steps) ? `${Number(steps.toPrecision(9))} steps/${unit.value}` : "";
    });
  };
  const oninput = () => (show(), (said.textContent = ""));
  const onsubmit = (event) => {
    event.preventDefault();
    const [before, axes] = [{ unit: machine.unit, axes: machine.axes }, rows.map(({ built }) => built())];
    machine.keep(unit.value, axes);
    const why = change();
    if (why) machine.keep(before.unit, before.axes);
    said.textContent = why ?? "Kept by this browser.";
  };
  show();
  const label = element("label", ["Lengths are shown in ", unit]);
  return element("form", [label, wide, element("button", "Save"), said], { id: "machine", oninput, onsubmit });
}
