// The settings of the board, by the names they have everywhere, and the machine file.

import { element } from "./dom.js";
import { post } from "./server.js";
import { fieldOf, grouped } from "./settings-fields.js";

/** One setting: its number, its range, and what it does. */
class Row {
  constructor(sheet, axes) {
    this.name = sheet.name;
    this.field = fieldOf(sheet, () => this.send(), axes);
    this.input = this.field.input;
    this.input.id = `set-${sheet.name}`;
    const button = (word, className) => element("button", word, { className, ariaLabel: `${word} ${sheet.name}` });
    this.set = button("Set", "");
    this.reset = button("Reset", "quiet");
    this.error = element("p", [], { className: "no", role: "alert", id: `${this.input.id}-error`, hidden: true });
    // Boxes have labels of their own; this one is for all.
    const boxes = this.input.type === "checkbox";
    const label = element(boxes ? "span" : "label", sheet.name, { className: "name", htmlFor: this.input.id });
    this.mark = element("span", "changed", "mark");
    const parts = this.field.parts.map((part) => (typeof part === "string" ? element("span", part) : part));
    const number = element("td", parts, "number");
    if (boxes) Object.assign(number, { role: "group", ariaLabel: sheet.name });
    this.row = element("tr", [
      element("th", [label, " ", this.mark], { scope: "row" }),
      number,
      element("td", this.field.range, "range"),
      element("td", [this.field.help, this.error], "help"),
      element("td", [this.set, this.reset], "buttons"),
    ]);
    this.row.dataset.name = sheet.name;
    this.set.hidden = !this.field.typed;
    this.input.oninput = () => this.show();
    if (this.field.typed) this.input.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.send();
      if (event.key === "Escape") this.undo();
    });
    this.set.onclick = () => this.send();
    this.reset.onclick = () => this.send(this.sheet.default);
    this.describe(sheet);
  }

  /** The setting as the board has it now. Text being typed stays. */
  describe(sheet) {
    const typed = this.sheet && this.isTyped();
    this.sheet = sheet;
    if (!typed) this.field.value = sheet.value;
    this.show();
  }

  isTyped() {
    return this.field.value !== String(this.sheet.value);
  }

  get changed() {
    return this.sheet.value !== this.sheet.default;
  }

  undo() {
    this.field.value = this.sheet.value;
    this.tell(null);
    this.show();
  }

  show() {
    this.mark.hidden = !this.changed;
    this.mark.title = `default: ${this.sheet.default}`;
    this.row.classList.toggle("changed", this.changed);
    this.set.disabled = !this.able || !this.isTyped();
    this.reset.disabled = !this.able || !this.changed;
    this.reset.title = `to ${this.sheet.default}`;
    this.field.allow(this.able);
  }

  tell(error) {
    this.error.hidden = !error;
    this.error.textContent = error?.message ?? "";
    this.input.toggleAttribute("aria-invalid", Boolean(error));
    if (error) this.input.setAttribute("aria-describedby", this.error.id);
    else this.input.removeAttribute("aria-describedby");
  }

  /** Sends it; a refusal is shown beside it. */
  async send(number) {
    const text = this.field.value;
    const value = number ?? Number(text);
    if (number === undefined && (text === "" || Number.isNaN(value))) {
      const { min, max, unit } = this.sheet;
      this.tell({ message: `'${text}' is no number. Allowed: ${min} to ${max} ${unit}`.trim() });
      return;
    }
    try {
      await post("/api/set", { name: this.name, value });
      this.tell(null);
      this.sheet = { ...this.sheet, value };
      this.field.value = value;
    } catch (declined) {
      this.tell(declined);
      // A box shows its setting; typed text stays.
      if (!this.field.typed) this.field.value = this.sheet.value;
    }
    this.show();
  }

  allow(able) {
    this.able = able;
    this.show();
  }
}

export class Settings {
  constructor(section) {
    this.rows = [];
    this.able = false;
    const title = element("h2", "Settings of the board", { id: "settings-title" });
    this.count = element("p", [], "count");
    this.all = element("button", "Reset all", { className: "quiet", onclick: () => this.resetAll(), onblur: () => this.ask(false) });
    const hint = element("p", "A setting holds at once. An Uno, Nano or Mega keeps it without power. None is changed while a motor moves.", "soft");
    this.table = element("table", [], "settings");
    this.machine = element("div", [], "machine");
    section.append(element("div", [title, this.count, this.all], "head"), hint, this.table, this.machine);
  }

  /** A board, as in GET /api/board. */
  describe(board) {
    const names = board.settings.map((sheet) => sheet.name).join();
    if (names !== this.rows.map((row) => row.name).join()) {
      this.rows = board.settings.map((sheet) => new Row(sheet, board.axes.length));
      const rowOf = (sheet) => this.rows.find((row) => row.name === sheet.name).row;
      this.table.replaceChildren(...grouped(board.settings).map(([title, sheets]) => {
        const head = element("th", title, { className: "group", colSpan: 5, scope: "rowgroup" });
        return element("tbody", [element("tr", head), ...sheets.map(rowOf)]);
      }));
      this.allow(this.able, true);
    } else {
      board.settings.forEach((sheet, i) => this.rows[i].describe(sheet));
    }
    const changed = this.rows.filter((row) => row.changed).length;
    this.count.textContent = this.rows.length
      ? `${changed} of ${this.rows.length} differ from their defaults`
      : "This board has none that can be set over its line";
    this.ask(false);
    this.describeMachine(board);
  }

  /** Whether they can be set: this page controls. */
  allow(able, anew = false) {
    if (able === this.able && !anew) return;
    this.able = able;
    this.rows.forEach((row) => row.allow(able));
    this.ask(false);
  }

  /** The button asks again before it resets all. */
  ask(on) {
    const changed = this.rows.filter((row) => row.changed).length;
    this.asked = on;
    this.all.textContent = on ? `Reset these ${changed}?` : "Reset all";
    this.all.disabled = !this.able || changed === 0;
  }

  async resetAll() {
    if (!this.asked) {
      this.ask(true);
      return;
    }
    for (const row of this.rows.filter((one) => one.changed)) await row.send(row.sheet.default);
    this.ask(false);
  }

  /** The machine file, as it was read; without a server a form, which keeps its input. */
  describeMachine({ machine, form, axes: { length: count } }) {
    if (form) {
      if (this.machine.dataset.axes === String(count)) return;
      this.machine.dataset.axes = count;
      this.machine.replaceChildren(element("h2", "Machine"), form());
      return;
    }
    const title = element("h2", "Machine file");
    if (!machine) {
      const none = ["None was read: lengths are steps. ", element("code", "stepwright init"), " asks what the machine is like, and writes one."];
      this.machine.replaceChildren(title, element("p", none, "soft"));
      return;
    }
    const from = [element("code", machine.file), ". It is read when the server starts; what was typed behind the command goes before it."];
    const axes = [...new Set(machine.values.map((one) => one.axis))].sort((a, b) => (a ?? 0) - (b ?? 0));
    const names = [...new Set(machine.values.map((one) => one.name))];
    const head = [element("td"), ...axes.map((axis) => element("th", axis === null ? "all" : `Axis ${axis}`))];
    const rows = names.map((name) => {
      const said = (axis) => machine.values.find((one) => one.name === name && one.axis === axis)?.value ?? "";
      return element("tr", [element("th", name), ...axes.map((axis) => element("td", said(axis)))]);
    });
    this.machine.replaceChildren(title, element("p", from, "soft"), element("table", [element("tr", head), ...rows], "values"));
  }
}
