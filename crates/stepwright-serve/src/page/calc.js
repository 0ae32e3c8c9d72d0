// The calculators: what GET /api/calc lists, with a field for each option.

import { element } from "./dom.js";
import { get, post } from "./server.js";

/** What each begins with. */
const EXAMPLES = {
  timer: { SPEED: "180" },
  timed: { FROM: "1rpm", TO: "150rpm", "--updates": "11", "--doubling": true },
  belt: { "--teeth": "20" },
  screw: { "--pitch": "2mm" },
  delay: { "--period": "200us" },
  vref: { CURRENT: "1.7A" },
};

/** The name of an option without the dashes of a command. */
const called = (name) => name.replace(/^--/, "").replaceAll("-", " ").toLowerCase();

/** A text of the command, its options called as the fields are. */
const plain = (text) => text.replaceAll(/--([a-z][a-z-]*)( <[A-Z]+>)?/g, (_, name) => called(name));

/** A field for an option: a box to tick, a list, or text. */
function field(option) {
  if (!option.takes_value) {
    const box = element("input");
    box.type = "checkbox";
    return box;
  }
  if (option.choices.length) {
    const list = element("select");
    list.append(...option.choices.map((one) => new Option(one, one, false, one === option.default)));
    return list;
  }
  const text = element("input");
  text.type = "text";
  text.autocomplete = "off";
  text.placeholder = option.default ?? "";
  text.required = option.required;
  return text;
}

export class Calculators {
  constructor(section) {
    this.section = section;
    this.asked = 0;
    const head = element("div", "", "head");
    const title = element("h2", "Calculators");
    title.id = "calc-title";
    this.choice = element("select");
    this.choice.onchange = () => this.choose();
    const label = element("label", "Which ");
    label.append(this.choice);
    head.append(title, label);
    this.about = element("p", "", "soft");
    this.form = element("form", "", "calc");
    this.form.noValidate = true;
    this.form.oninput = () => this.compute();
    this.form.onsubmit = (event) => (event.preventDefault(), this.compute());
    this.line = element("details", "", "soft");
    this.line.append(element("summary", "As a command"), element("code"));
    this.result = element("div", "", "result");
    this.result.setAttribute("aria-live", "polite");
    section.append(head, this.about, this.form, this.result, this.line);
    new ResizeObserver(() => this.begin()).observe(section);
  }

  /** Asks what there is, once, when somebody looks. */
  async begin() {
    if (this.sheets || !this.section.clientWidth) return;
    this.sheets = [];
    this.sheets = await get("/api/calc");
    this.choice.append(...this.sheets.map((sheet) => new Option(sheet.name)));
    this.choice.value = "belt";
    this.choose();
  }

  choose() {
    const sheet = this.sheets.find((one) => one.name === this.choice.value);
    this.about.textContent = sheet.about;
    this.fields = sheet.options.map((option) => ({ option, input: field(option) }));
    this.form.replaceChildren(...this.fields.map(({ option, input }) => {
      const label = element("label", "", option.takes_value ? "" : "tick");
      const said = element("span", called(option.name));
      label.append(...(option.takes_value ? [said, input] : [input, said]), element("small", plain(option.help)));
      input.name = option.name;
      const example = EXAMPLES[sheet.name]?.[option.name];
      if (example === true) input.checked = true;
      else if (example) input.value = example;
      return label;
    }));
    this.compute();
  }

  words() {
    const words = [this.choice.value];
    const bare = [];
    for (const { option, input } of this.fields) {
      const value = input.type === "checkbox" ? input.checked : input.value.trim();
      if (value === "" || value === false || value === option.default) continue;
      if (option.bare) bare.push(...value.split(/\s+/));
      else words.push(option.name, ...(value === true ? [] : [value]));
    }
    return [...words, ...bare];
  }

  async compute() {
    const mine = ++this.asked;
    const words = this.words();
    this.line.querySelector("code").textContent = `stepwright calc ${words.join(" ")}`;
    const missing = this.fields.filter(({ option, input }) => option.required && !input.value.trim());
    if (missing.length) {
      const names = missing.map(({ option }) => called(option.name));
      this.result.replaceChildren(element("p", `Needed: ${names.join(", ")}`, "soft"));
      return;
    }
    let shown;
    try {
      shown = this.show(await post("/api/calc", { words }));
    } catch (declined) {
      shown = [element("p", plain(declined.message), "no")];
    }
    // Another one may have been asked meanwhile.
    if (mine === this.asked) this.result.replaceChildren(...shown);
  }

  show({ title, facts, columns, rows, notes }) {
    const parts = [element("h3", title)];
    const table = (name, lines) => {
      const made = element("table", "", name);
      made.append(...lines);
      const box = element("div", "", "wide");
      box.append(made);
      return box;
    };
    const row = (tag, cells) => {
      const made = element("tr");
      made.append(...cells.map((cell) => element(tag, cell)));
      return made;
    };
    if (facts.length) parts.push(table("values", facts.map((one) => row("td", [one.name, `${one.value} ${one.unit}`]))));
    if (rows.length) parts.push(table("values", [row("th", columns), ...rows.map((cells) => row("td", cells))]));
    parts.push(...notes.map((note) => element("p", note, "soft")));
    return parts;
  }
}
