// The calculators of GET /api/calc, with a field for each option.

import { element, looked, once } from "./dom.js";
import { get, post } from "./server.js";

/** The first examples. */
const EXAMPLES = {
  timer: { SPEED: "180" },
  timed: { FROM: "1rpm", TO: "150rpm", "--updates": "11", "--doubling": true },
  belt: { "--teeth": "20" },
  screw: { "--pitch": "2mm" },
  delay: { "--period": "200us" },
  vref: { CURRENT: "1.7A" },
};

/** An option's name without the dashes of a command. */
const called = (name) => name.replace(/^--/, "").replaceAll("-", " ").toLowerCase();

/** A text of the command, its options called as the fields are. */
const plain = (text) => text.replaceAll(/--([a-z][a-z-]*)( <[A-Z]+>)?/g, (_, name) => called(name));

/** A field for an option: a checkbox, a list, or text. */
function field(option) {
  if (!option.takes_value) return element("input", [], { type: "checkbox" });
  if (option.choices.length) return element("select", option.choices.map((one) => new Option(one, one, false, one === option.default)));
  return element("input", [], { type: "text", autocomplete: "off", placeholder: option.default ?? "", required: option.required });
}

const table = (lines) => element("div", element("table", lines, "values"), "wide");
const row = (tag, cells) => element("tr", cells.map((cell) => element(tag, cell)));

export class Calculators {
  /** `tell(error)` shows refusals. */
  constructor(section, tell) {
    this.asked = 0;
    this.choice = element("select", [], { onchange: () => this.choose() });
    const title = element("h2", "Calculators", { id: "calc-title" });
    const head = element("div", [title, element("label", ["Which ", this.choice])], "head");
    this.about = element("p", [], "soft");
    const compute = () => this.compute();
    const onsubmit = (event) => (event.preventDefault(), compute());
    this.form = element("form", [], { className: "calc", noValidate: true, oninput: compute, onsubmit });
    this.line = element("code");
    const line = element("details", [element("summary", "As a command"), this.line], "soft");
    this.result = element("div", [], { className: "result", ariaLive: "polite" });
    section.append(head, this.about, this.form, this.result, line);
    // Asks for the list at the first look.
    const begin = once(async () => {
      this.sheets = await get("/api/calc");
      this.choice.append(...this.sheets.map((sheet) => new Option(sheet.name)));
      this.choice.value = "belt";
      this.choose();
    });
    looked("#calc", () => begin().catch(tell));
  }

  choose() {
    const sheet = this.sheets.find((one) => one.name === this.choice.value);
    this.about.textContent = sheet.about;
    this.fields = sheet.options.map((option) => ({ option, input: field(option) }));
    this.form.replaceChildren(...this.fields.map(({ option, input }) => {
      const said = element("span", called(option.name));
      const parts = option.takes_value ? [said, input] : [input, said];
      input.name = option.name;
      const example = EXAMPLES[sheet.name]?.[option.name];
      if (example === true) input.checked = true;
      else if (example) input.value = example;
      return element("label", [...parts, element("small", plain(option.help))], option.takes_value ? "" : "tick");
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
    this.line.textContent = `stepwright calc ${words.join(" ")}`;
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
    if (facts.length) parts.push(table(facts.map((one) => row("td", [one.name, `${one.value} ${one.unit}`]))));
    if (rows.length) parts.push(table([row("th", columns), ...rows.map((cells) => row("td", cells))]));
    return [...parts, ...notes.map((note) => element("p", note, "soft"))];
  }
}
