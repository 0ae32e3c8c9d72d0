// Answers the views in place of `stepwright serve`: by the host library, and with what only this
// page knows: the machine and the drawings of the examples.

import { Declined } from "../declined.js";
import { Machine, machineForm } from "../machine.js";
import { paths } from "./paths.js";

/** Control: there is no other client. */
const CONTROL = { hand: 1, key: "page", lease_ms: 2500 };

export class Keeper {
  constructor(host) {
    this.host = host;
    this.machine = new Machine();
    /** Counts changes of the machine, as the board's sheet counts its settings. */
    this.machines = 0;
    this.told = () => {};
    host.told = (message) => this.hear(message);
  }

  /** The board's wire. */
  get wire() {
    return this.host.wire;
  }

  use(wire) {
    return this.host.use(wire);
  }

  /** A request, as to the server. */
  async ask(path, body) {
    const [, name, query] = /^\/api\/([a-z/]*)\??(.*)$/.exec(path);
    const value = (key) => new URLSearchParams(query).get(key);
    if (name === "board") return this.board();
    if (name === "state") return this.state;
    if (name === "scope") return this.scope(Number(value("seconds")));
    if (name === "scope/file") return this.host.file(value("ending"), body);
    if (name.startsWith("path")) return paths(name, body);
    if (name.startsWith("control")) return CONTROL;
    return this.host.ask(name, body);
  }

  /** Has `hear(message)` get the messages. */
  follow(hear) {
    this.told = hear;
    if (this.state) hear(this.state);
    return { questions: (on) => this.host.questions(on) };
  }

  hear(message) {
    if (message.type === "board") {
      this.sheet = message;
      return;
    }
    if (message.type === "state") {
      message.sheet += this.machines;
      this.state = message;
    }
    // A view waits for the first sheet.
    if (this.sheet) this.told(message);
  }

  async scope(seconds) {
    if (this.wire.scope) return this.wire.scope(seconds);
    throw new Declined({ what: "nobody sees the edges of this board", do: "`stepwright serve` shows the planned ones" }, 404);
  }

  /** The sheet of the board, in the units of the machine. */
  board() {
    const axes = this.sheet.axes.map((one) => ({ ...one, ...this.machine.of(one.axis) }));
    // A command has another name for a browser's port, unknown here.
    const port = this.wire?.port && "PORT";
    return { ...this.sheet, port, axes, form: () => machineForm(this.machine, axes.length, () => this.remade()) };
  }

  /** Applies a changed machine, or returns why not now. */
  remade() {
    if (this.state.axes.some((axis) => axis.moving)) return "Not while a motor moves: it stays as it was.";
    this.machines++;
    this.hear({ ...this.state, sheet: this.state.sheet + 1 - this.machines });
    return null;
  }
}
