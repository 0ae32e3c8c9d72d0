// The machine of a page without a server: the unit of its axes, and the steps of one. The browser
// keeps it, and the settings show its form.

import { element } from "./dom.js";

const KEPT = "stepwright-machine";

/** The units, and their titles. */
const UNITS = { steps: "steps", mm: "millimetres", deg: "degrees" };

/** What is asked of an axis: its title, from, to, by default. All but the last are whole. */
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

/** Steps of a unit of an axis that is built so. */
function perUnit(unit, { steps, micro, mm }) {
  return { steps: 1, mm: (steps * micro) / mm, deg: (steps * micro) / 360 }[unit];
}

/** The machine that is kept: a unit, and axes. What is damaged counts as none. */
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

  /** The unit of an axis, 1 …, and the steps of one. */
  of(axis) {
    return { unit: this.unit, steps_per_unit: perUnit(this.unit, this.built(axis)) };
  }

  /** How an axis is built. */
  built(axis) {
    return this.axes[axis - 1] ?? usual();
  }

  keep(unit, axes) {
    Object.assign(this, { unit, axes });
    try {
      localStorage.setItem(KEPT, JSON.stringify({ unit, axes }));
    } catch {
      // It holds until the page is closed.
    }
  }
}

/** The form of the machine of so many axes; `change()` says that another unit holds, or why not. */
export function machineForm(machine, count, change) {
  const form = element("form");
  form.id = "machine";
  const unit = element("select");
  unit.name = "unit";
  unit.append(...Object.entries(UNITS).map(([name, title]) => new Option(title, name)));
  unit.value = machine.unit;
  const label = element("label", "Lengths are shown in ");
  label.append(unit);
  const table = element("table");
  table.className = "values";
  const head = element("tr");
  head.append(element("th", "Axis"), ...Object.values(ASKED).map(([title]) => element("th", title)), element("th", "It is"));
  const rows = Array.from({ length: count }, (_, n) => {
    const row = element("tr");
    const built = machine.built(n + 1);
    const inputs = Object.entries(ASKED).map(([name, [title, min, max]]) => {
      const input = element("input");
      Object.assign(input, { type: "number", name: `${name}-${n + 1}`, min, max, step: name === "mm" ? "any" : 1, required: true, value: built[name] });
      input.setAttribute("aria-label", `Axis ${n + 1}: ${title}`);
      return input;
    });
    const cells = inputs.map((input) => {
      const cell = element("td");
      cell.append(input);
      return cell;
    });
    const is = element("td");
    row.append(element("th", n + 1), ...cells, is);
    const read = () => Object.fromEntries(Object.keys(ASKED).map((name, at) => [name, inputs[at].valueAsNumber]));
    return { row, is, mm: inputs[2], built: read };
  });
  table.append(head, ...rows.map(({ row }) => row));
  const wide = element("div");
  wide.className = "wide";
  wide.append(table);
  const said = element("p");
  said.className = "soft";
  said.setAttribute("role", "status");
  const show = () => {
    wide.hidden = unit.value === "steps";
    for (const { is, mm, built } of rows) {
      mm.disabled = unit.value !== "mm";
      const steps = perUnit(unit.value, built());
      is.textContent = Number.isFinite(steps) ? `${Number(steps.toPrecision(9))} steps/${unit.value}` : "";
    }
  };
  form.oninput = () => (show(), (said.textContent = ""));
  form.onsubmit = (event) => {
    event.preventDefault();
    const [before, axes] = [{ unit: machine.unit, axes: machine.axes }, rows.map(({ built }) => built())];
    machine.keep(unit.value, axes);
    const why = change();
    if (why) machine.keep(before.unit, before.axes);
    said.textContent = why ?? "Kept by this browser.";
  };
  const save = element("button", "Save");
  form.append(label, wide, save, said);
  show();
  return form;
}
