// The host library as WebAssembly (`stepwright-wasm-host`): requests in, messages out, and a wire to
// a board. Orders, homing and the lease are in there; this file carries bytes, time and texts.
//
// Nothing here needs a page: Node runs it too.
//
// A wire: name · open() · write(bytes) · close() · onbytes(bytes) · ongone(error). Results of a
// write come later, not within it.

import { Declined } from "../declined.js";

/** Between two attempts to meet a lost board, in ms. */
const AGAIN = 500;

/** Events, by their numbers. */
const [TIME, BYTES, ASK, OPEN, FAILED, GONE, LEAVE, QUESTIONS, NO_QUESTIONS] = Array(9).keys();

export class Host {
  /** From the module's bytes. */
  static async open(module) {
    const { instance } = await WebAssembly.instantiate(module, {});
    return new Host(instance.exports);
  }

  constructor(door) {
    this.door = door;
    this.begun = performance.now();
    /** Requests without an answer yet, by number. */
    this.asked = new Map();
    this.count = 0;
    /** Gets every message that is no answer. */
    this.told = () => {};
  }

  /** Leaves the present board for the one at the end of this wire; returns when it is met, or
   *  can't be. */
  async use(wire) {
    await this.leave();
    this.wire = wire;
    wire.onbytes = (bytes) => this.turn(BYTES, bytes);
    wire.ongone = (error) => this.turn(GONE, error.message);
    const met = new Promise((met) => (this.met = met));
    await this.connect(wire);
    await met;
  }

  async connect(wire) {
    let failed;
    await wire.open().catch((error) => (failed = error));
    if (this.wire !== wire) await wire.close();
    else if (failed) this.turn(FAILED, `${wire.name}\n${failed.message}`);
    else this.turn(OPEN, wire.name);
  }

  /** Brakes all motors, and leaves the board. */
  async leave() {
    const { wire } = this;
    if (!wire) return;
    clearTimeout(this.again);
    const left = new Promise((left) => (this.left = left));
    this.turn(LEAVE);
    await left;
    this.wire = null;
    await wire.close();
  }

  /** Asks as `POST /api/NAME` does: the lines that the board took; with `NAME?wait=true` how the
   *  order ended. */
  ask(name, body = {}) {
    return new Promise((take, fail) => {
      this.asked.set(++this.count, { take, fail });
      this.turn(ASK, `${this.count} ${name}\n${JSON.stringify(body)}`);
    });
  }

  /** Whether questions to the board are reported too. */
  questions(on) {
    this.turn(on ? QUESTIONS : NO_QUESTIONS);
  }

  /** A record as a file with this ending: vcd, csv, mcap. */
  file(ending, record) {
    this.put(new TextEncoder().encode(`${ending}\n${JSON.stringify(record)}`));
    if (!this.door.stepwright_file()) throw new Declined({ what: `there is no ${ending} of this record` }, 422);
    return this.out(2);
  }

  put(bytes) {
    // Room may move the memory.
    const at = this.door.stepwright_room(bytes.length);
    new Uint8Array(this.door.memory.buffer, at, bytes.length).set(bytes);
  }

  out(which) {
    const at = this.door.stepwright_out(which);
    return new Uint8Array(this.door.memory.buffer, at, this.door.stepwright_out_len(which)).slice();
  }

  /** Handles this event. */
  turn(event = TIME, what = "") {
    this.put(typeof what === "string" ? new TextEncoder().encode(what) : what);
    const due = this.door.stepwright_turn(performance.now() - this.begun, event);
    clearTimeout(this.timer);
    if (due < Infinity) this.timer = setTimeout(() => this.turn(), Math.ceil(due));
    const [bytes, messages] = [this.out(0), new TextDecoder().decode(this.out(1))];
    if (bytes.length) this.wire.write(bytes);
    for (const message of messages.split("\n").slice(0, -1)) this.hear(JSON.parse(message));
  }

  hear(message) {
    if (message.type === "answer") {
      const { take, fail } = this.asked.get(message.id);
      this.asked.delete(message.id);
      if (message.done) take(message.done);
      else fail(new Declined(message.declined, message.status));
    } else if (message.type === "closed") {
      this.met();
      if (message.lost) this.lose(this.wire);
      else this.left();
    } else {
      if (message.connected) this.met();
      this.told(message);
    }
  }

  /** Meets the board again when it is back. */
  async lose(wire) {
    await wire.close();
    if (this.wire === wire) this.again = setTimeout(() => this.wire === wire && this.connect(wire), AGAIN);
  }
}
