// The Paths view: a file of lines, arcs and other moves, drawn before anything moves.

import { dark, places } from "./colours.js";
import { by, choose, copy, digits, element, looked, once, save } from "./dom.js";
import { Declined } from "./declined.js";
import { first } from "./edges.js";
import { PathCanvas, ramp } from "./paths-draw.js";
import { quoted } from "./plan-copy.js";
import { get, post } from "./server.js";

/** The names of legs. */
const KINDS = { line: "Line", arc: "Arc", path: "Path", home: "Homing", moves: "Moves", rest: "Rest", rapid: "Rapid", probe: "Probe" };

/** The states of a run. */
const RUNS = {
  running: "is running", held: "is held", braking: "brakes", done: "was run to its end", stopped: "was stopped", killed: "was killed",
  failed: "broke off",
};

/** The text is drawn this long after a change, in ms. */
const LATER = 400;

/** Longer texts are not edited here: it would take seconds. */
const LONG = 300_000;

/** This many lines of a long text are shown around the marked one. */
const AROUND = 60;

/** Larger units, shown if the values are large enough. */
const SHOWN = { nm: [["mm", 1e6], ["µm", 1e3]], µm: [["mm", 1e3]] };

/** A drawing as in POST /api/path, in a unit with short numbers. */
export function scaled(drawing) {
  const all = drawing.places.flat();
  const largest = all.reduce((most, place) => Math.max(most, Math.abs(place)), 0);
  const [unit, per] = (SHOWN[drawing.unit] ?? []).find(([, per]) => !largest || largest >= per) ?? [drawing.unit, 1];
  const { times, legs, seconds } = drawing;
  const sheet = {
    id: drawing.id, kind: drawing.kind, facts: drawing.facts, refused: drawing.refused, unit, per, times, seconds,
    motors: drawing.motors.map((motor) => motor.name),
    steps: drawing.motors.map((motor) => motor.step / per),
    places: drawing.places.map((places) => places.map((place) => place / per)),
    speeds: drawing.speeds.map((speed) => speed / per),
    peak: drawing.peak / per,
    powers: drawing.powers,
  };
  // Shown as colour: a part of the maximum.
  sheet.shades = sheet.powers ?? sheet.speeds.map((speed) => speed / (sheet.peak || 1));
  const moves = ({ first, last }) => sheet.places.some((places) => places.slice(first, last + 1).some((place) => place !== places[first]));
  sheet.legs = legs.map((leg) => ({ ...leg, peak: leg.peak / per, moves: moves(leg) }));
  sheet.stands = [];
  for (let n = 0; n < times.length; n++) {
    if (sheet.speeds[n] > 0) continue;
    const last = sheet.stands.at(-1);
    if (last && last.end === n - 1) Object.assign(last, { end: n, seconds: times[n] - times[last.point] });
    else sheet.stands.push({ point: n, end: n, seconds: 0 });
  }
  // Rows of the table: a leg in several parts is one row.
  sheet.rows = [];
  sheet.legs.forEach((leg, n) => {
    const last = sheet.rows.at(-1);
    if (last && last.line === leg.line && last.kind === leg.kind) {
      last.legs.push(n);
      last.end = leg.end;
      last.peak = Math.max(last.peak, leg.peak);
    } else sheet.rows.push({ ...leg, legs: [n] });
  });
  return sheet;
}

/** The motors' places at a time, their speed, and a laser's power. */
function placeAt(sheet, time) {
  const next = first(sheet.times.length, (n) => sheet.times[n] > time);
  const n = Math.min(Math.max(next, 1), sheet.times.length - 1);
  const [from, to] = [sheet.times[n - 1], sheet.times[n]];
  const part = to > from ? Math.min(Math.max((time - from) / (to - from), 0), 1) : 1;
  // Nothing moves between two legs.
  const leap = sheet.legs.some((leg) => leg.first === n);
  const mix = (values) => (leap ? values[part < 1 ? n - 1 : n] : values[n - 1] + (values[n] - values[n - 1]) * part);
  return { time, speed: mix(sheet.speeds), places: sheet.places.map(mix), power: sheet.powers && mix(sheet.powers) };
}

export class PathsView {
  /** `tell(error)` shows refusals. */
  constructor(tell) {
    this.tell = tell;
    this.sheet = null;
    this.row = null;
    this.asked = 0;
    this.report = null;
    this.ours = false;
    this.canvas = new PathCanvas(by("paths-way"), by("paths-strip"));
    by("paths").view = this;
    by("paths-edit").open = innerWidth > 960;
    this.listen();
  }

  /** Opens at the first look. */
  open = once(async () => {
    const { player, ...table } = await get("/api/path/examples");
    Object.assign(this, { cycles: player, ...table });
    if (this.job_endings) by("paths-pick").accept = [".toml", ...this.job_endings, "text/plain"].join();
    const report = await get("/api/path");
    if (report && !this.report) this.hear(report);
    const options = this.examples.map(({ name }, n) => new Option(name, n));
    by("paths-file").replaceChildren(...options);
    await this.use(this.examples[0]);
  });

  /** Draws a file. `laser`: its S of full power, or null; undefined keeps it. */
  use({ name, text, laser }) {
    this.name = name;
    by("paths-laser").hidden = !this.isJob(name);
    if (laser !== undefined) by("paths-laser-on").checked = laser !== null;
    if (laser) by("paths-laser-most").value = laser;
    this.long = text.length > LONG ? text.split("\n") : null;
    const area = by("paths-text");
    area.readOnly = Boolean(this.long);
    area.value = this.long ? "" : text;
    by("paths-long").textContent = "";
    if (this.long) this.mark(1);
    const known = this.examples.findIndex((one) => one.name === name && one.text === text);
    let own = by("paths-file").querySelector("[value=own]");
    if (known >= 0) by("paths-file").value = known;
    else {
      if (!own) by("paths-file").prepend((own = new Option("", "own")));
      own.textContent = name;
      by("paths-file").value = "own";
      this.own = { name, text };
    }
    this.isOwn = known < 0;
    return this.drawFile();
  }

  /** Whether a file of this name is a G-code job. */
  isJob(name) {
    return this.job_endings?.some((ending) => name.toLowerCase().endsWith(ending));
  }

  /** A laser's S of full power, or null. */
  get laser() {
    return this.isJob(this.name) && by("paths-laser-on").checked ? by("paths-laser-most").valueAsNumber : null;
  }

  get file() {
    return { name: this.name, text: this.long ? this.long.join("\n") : by("paths-text").value, laser: this.laser };
  }

  async drawFile() {
    const asked = ++this.asked;
    const { file } = this;
    by("paths").setAttribute("aria-busy", "true");
    try {
      const drawing = await post("/api/path", file);
      if (asked !== this.asked) return;
      this.wrong(null);
      this.show(drawing);
    } catch (declined) {
      if (asked === this.asked) this.wrong(declined);
    } finally {
      if (asked === this.asked) by("paths").removeAttribute("aria-busy");
    }
  }

  /** Shows an error in the file: the drawing is no longer this file's. */
  wrong(declined) {
    by("paths-wrong").replaceChildren(...(declined ? [element("li", declined.message)] : []));
    by("paths").classList.toggle("wrong", Boolean(declined));
    this.allow(this.ours);
    by("paths-text").style.setProperty("--marked", -9);
    if (!declined) return;
    const [, line, column] = /, line (\d+)(?:, column (\d+))?:/.exec(declined.message) ?? [];
    if (line) this.mark(Number(line), Number(column ?? 1));
    if (declined.status && declined.status !== 422 && declined.status !== 413) this.tell(declined);
  }

  /** Shows a line of the text, from this column on. */
  mark(line, column = 1) {
    const area = by("paths-text");
    let before = 0;
    if (this.long) {
      before = Math.max(0, line - 1 - AROUND);
      const until = Math.min(this.long.length, line + AROUND);
      area.value = this.long.slice(before, until).join("\n");
      by("paths-long").textContent = `Lines ${before + 1} to ${until} of ${this.long.length}. So long a text is changed in an editor, and dropped here again.`;
    }
    const lines = area.value.split("\n");
    const begin = lines.slice(0, line - before - 1).join("\n").length + (line - before > 1);
    const end = begin + (lines[line - before - 1] ?? "").length;
    if (document.activeElement !== area) area.setSelectionRange(Math.min(begin + column - 1, end), end);
    area.style.setProperty("--marked", line - before - 1);
    area.scrollTop = (line - before - 4) * parseFloat(getComputedStyle(area).lineHeight);
  }

  show(drawing) {
    const kept = this.sheet?.motors.join() === drawing.motors.map((motor) => motor.name).join();
    this.sheet = scaled(drawing);
    this.choices(kept);
    this.player();
    this.facts();
    this.table();
    this.legend();
    const slide = by("paths-time");
    slide.max = this.sheet.seconds;
    slide.step = this.sheet.seconds / 2000 || 1;
    this.choose(null);
    this.drawWay();
    if (!this.follow()) this.seek(0);
    this.allow(this.ours);
  }

  /** Where the file is run, or why it can't be. */
  player() {
    const { kind, refused } = this.sheet;
    const job = kind === "gcode" && this.jobs;
    by("paths-player").textContent = job ? this.jobs : this.cycles;
    const board = job ? this.job_board : this.board;
    by("paths-go").textContent = board ? `Run on ${board}` : "Run";
    by("paths-refused").textContent = refused ?? "";
  }

  /** Facts about the file; those of a line lead to it. */
  facts() {
    const lists = { "paths-facts": [], "paths-corners": [] };
    for (const { name, value, line } of this.sheet.facts ?? []) {
      const term = line ? element("button", `Line ${line}: ${name}`, { onclick: () => this.mark(line) }) : name;
      lists[line ? "paths-corners" : "paths-facts"].push(element("dt", term), element("dd", value));
    }
    for (const [id, list] of Object.entries(lists)) by(id).replaceChildren(...list);
    by("paths-corners").parentElement.hidden = !lists["paths-corners"].length;
  }

  // The run.

  get running() {
    return ["running", "held", "braking"].includes(this.report?.state);
  }

  /** A run's progress. */
  hear(report) {
    const before = this.report;
    this.report = report;
    const { name, state, seconds, trouble } = report;
    const said = by("paths-state");
    const whole = this.isThis(report) ? ` of ${this.sheet.seconds.toFixed(2)}` : "";
    const at = state === "failed" ? "" : `: ${seconds.toFixed(2)}${state === "done" ? "" : whole} s`;
    said.textContent = `${name} ${RUNS[state]}${at}`;
    said.className = state;
    if (trouble && before?.state !== state) {
      const error = new Declined(trouble);
      // After other errors the file may be run again.
      if (/, line \d+/.test(trouble.what)) this.wrong(error);
      else this.tell(error);
    }
    if (before?.state !== state) this.allow(this.ours);
    this.follow(before);
  }

  /** The server is gone, and with it its player. */
  lost() {
    if (this.running) by("paths-state").textContent = "The server does not answer";
    this.report = null;
    this.allow(false);
  }

  /** Whether it is the run of the drawn file. */
  isThis(report) {
    return report && this.sheet?.id === report.id;
  }

  /** Sets the playhead to the player's places: during a run, and at its end. */
  follow(before = null) {
    const { report, sheet } = this;
    if (!this.isThis(report) || !(this.running || (before && before.id === report.id))) return false;
    const places = report.places.map((place) => place / sheet.per);
    // By the last two reports.
    const time = before ? report.seconds - before.seconds : 0;
    const way = time > 0 ? Math.hypot(...places.map((place, n) => place - before.places[n] / sheet.per)) : 0;
    const leap = time > 0 && way / time > 1.5 * sheet.peak;
    by("paths-time").value = report.seconds;
    this.head({ time: report.seconds, places, speed: time > 0 && !leap ? way / time : undefined, done: report.state === "done" });
    return true;
  }

  /** Whether this page may run it. */
  allow(ours) {
    this.ours = ours;
    const go = by("paths-go");
    go.disabled = !ours || this.running || !this.sheet || Boolean(this.sheet.refused) || by("paths").classList.contains("wrong");
    go.title = ours ? "" : "Take control first";
    by("paths-time").disabled = this.running && this.isThis(this.report);
    const state = this.report?.state;
    const hold = by("paths-hold");
    // Also of a job that another page has opened.
    hold.hidden = !(["running", "held"].includes(state) && this.isJob(this.report.name));
    hold.textContent = state === "held" ? "Resume" : "Hold";
    hold.disabled = !ours;
  }

  run() {
    this.choose(null);
    post("/api/path/run", this.file).catch(this.tell);
  }

  /** Holds the run, or resumes it. */
  hold() {
    post(this.report?.state === "held" ? "/api/path/resume" : "/api/path/hold", {}).catch(this.tell);
  }

  /** Copies the command that runs the file, and shows it. */
  copy() {
    const file = quoted(this.name);
    const example = this.examples.some((one) => one.name === this.name);
    const { laser } = this;
    const on = laser !== null ? ` --laser --laser-max ${laser}` : this.job_port ? ` --port ${this.job_port}` : "";
    const text = this.sheet?.kind === "gcode"
      ? `stepwright gcode ${example ? "examples/gcode/" : ""}${file}${on}`
      : `stepwright cycle ${example ? "examples/cycles/" : ""}${file} --port ${this.port ?? "PORT"}`;
    copy(text, by("paths-copied"));
  }

  /** Which motors, or the time, are drawn. */
  choices(kept) {
    const [x, y] = [by("paths-x"), by("paths-y")];
    const before = [x.value, y.value];
    const motors = () => this.sheet.motors.map((name, n) => new Option(name, n));
    x.replaceChildren(...motors(), new Option("Time", -1));
    y.replaceChildren(...motors());
    const several = this.sheet.motors.length > 1;
    [x.value, y.value] = kept ? before : several ? [0, 1] : [-1, 0];
  }

  drawWay() {
    this.canvas.show(this.sheet, [Number(by("paths-x").value), Number(by("paths-y").value)]);
  }

  table() {
    const { sheet } = this;
    const shown = [...new Set(["paths-x", "paths-y"].map((id) => Number(by(id).value)))].filter((axis) => axis >= 0);
    const pair = (n) => shown.map((axis) => digits(sheet.places[axis][n], 5)).join(", ");
    const { cells: heads } = by("paths-legs").rows[0];
    heads[1].textContent = `To ${shown.map((axis) => sheet.motors[axis]).join(", ")}, ${sheet.unit}`;
    heads[3].textContent = `Peak, ${sheet.unit}/s`;
    const rows = sheet.rows.map((row, n) => {
      const several = row.kind === "lines";
      const text = several ? `Lines ${row.line} to ${row.to_line}` : `${n + 1} ${KINDS[row.kind] ?? row.kind}`;
      const title = several ? "" : `line ${row.line} of the file`;
      const button = element("button", text, { title, onclick: () => this.choose(this.row === n ? null : n) });
      const to = pair(sheet.legs[row.legs.at(-1)].last);
      const cells = [button, to, `${digits(row.end - row.begin, 4)} s`, row.peak ? digits(row.peak, 4) : "–"];
      return element("tr", cells.map((cell) => element("td", cell)));
    });
    by("paths-legs").tBodies[0].replaceChildren(...rows);
    const count = sheet.rows.length === 1 ? "1 part" : `${sheet.rows.length} parts`;
    by("paths-sum").textContent = sheet.seconds === 0 ? "Nothing moves in this file." : `${count}, ${digits(sheet.seconds, 5)} s, at most ${digits(sheet.peak, 4)} ${sheet.unit}/s`;
  }

  /** Highlights a row of the table, and sets the playhead to its beginning. */
  choose(n) {
    this.row = n;
    choose(by("paths-legs").tBodies[0].rows, n);
    this.canvas.choose(n === null ? null : this.sheet.rows[n].legs);
    if (n === null) return;
    if (!this.running) this.seek(this.sheet.rows[n].begin);
    this.mark(this.sheet.rows[n].line);
  }

  legend() {
    const { sheet } = this;
    const bar = by("paths-legend");
    const paint = ramp();
    const pen = bar.getContext("2d");
    for (let x = 0; x < bar.width; x++) {
      pen.fillStyle = paint(x / (bar.width - 1));
      pen.fillRect(x, 0, 1, bar.height);
    }
    const [least, most] = sheet.powers ? ["laser off", "full power"] : ["at rest", `${digits(sheet.peak, 4)} ${sheet.unit}/s`];
    by("paths-least").textContent = least;
    by("paths-most").textContent = most;
  }

  /** Sets the playhead to a time of the drawing. */
  seek(time) {
    by("paths-time").value = time;
    const at = placeAt(this.sheet, time);
    this.head({ ...at, done: time <= 0 || time >= this.sheet.seconds });
  }

  /** Sets the playhead, and shows its place. */
  head(head) {
    const { sheet } = this;
    this.canvas.at(head);
    const after = Math.min(places(Math.min(...sheet.steps)), 3);
    const where = sheet.motors.map((name, n) => `${name} ${head.places[n].toFixed(after).replace("-", "−")}`);
    const speed = head.speed === undefined ? [] : [`${digits(head.speed, 4)} ${sheet.unit}/s`];
    const power = head.power == null ? [] : [`laser ${(100 * head.power).toFixed(0)} %`];
    const words = [`${head.time.toFixed(2)} s`, `${where.join(", ")} ${sheet.unit}`, ...speed, ...power];
    by("paths-at").textContent = words.join(" · ");
    by("paths-time").setAttribute("aria-valuetext", words.join(", "));
  }

  save() {
    save(this.name, this.file.text);
  }

  async read(file) {
    if (!file) return;
    if (file.size > (this.longest ?? Infinity)) {
      const most = (this.longest / 1e6).toFixed(0);
      this.tell(new Error(`${file.name} is too long: at most ${most} MB are drawn here. \`stepwright gcode FILE --plan\` plans any job`));
      return;
    }
    try {
      await this.open();
      await this.use({ name: file.name.slice(0, 100), text: await file.text() });
    } catch (error) {
      this.tell(error);
    }
  }

  listen() {
    by("paths-file").oninput = (event) => {
      const { value } = event.target;
      // With its typed text, and its laser.
      if (this.isOwn) this.own = this.file;
      this.use(value === "own" ? this.own : this.examples[value]);
    };
    by("paths-laser").oninput = () => {
      if (Number.isNaN(this.laser)) this.wrong(new Error("S of full power is no number"));
      else this.drawFile();
    };
    by("paths-go").onclick = () => this.run();
    by("paths-hold").onclick = () => this.hold();
    by("paths-copy").onclick = () => this.copy();
    by("paths-save").onclick = () => this.save();
    by("paths-open").onclick = () => by("paths-pick").click();
    by("paths-pick").onchange = (event) => {
      this.read(event.target.files[0]);
      event.target.value = "";
    };
    by("paths-text").oninput = () => {
      clearTimeout(this.later);
      this.later = setTimeout(() => this.drawFile(), LATER);
    };
    const turned = () => (this.table(), this.choose(this.row), this.drawWay());
    for (const id of ["paths-x", "paths-y"]) by(id).oninput = turned;
    by("paths-time").oninput = (event) => this.sheet && this.seek(event.target.valueAsNumber);
    dark.addEventListener("change", () => this.sheet && this.legend());
    const section = by("paths");
    section.addEventListener("dragover", (event) => {
      event.preventDefault();
      section.classList.add("over");
    });
    section.addEventListener("dragleave", () => section.classList.remove("over"));
    section.addEventListener("drop", (event) => {
      event.preventDefault();
      section.classList.remove("over");
      this.read(event.dataTransfer.files[0]);
    });
    looked("#paths", () => this.open().catch(this.tell));
  }
}
