// A virtual board whose time passes as ours does, as a wire.
//
// Nothing here knows a page: Node runs it as well.

import { VirtualBoard } from "./virtual.js";

/** Between two moments of a board that hears nothing, in ms. */
const MOMENT = 10;

/** A machine that has slept does not catch up with more than this, in ms. */
const SLEPT = 1000;

export class PacedBoard {
  name = "the virtual board";

  /** From the bytes of the module. */
  constructor(module) {
    this.module = module;
  }

  async open() {
    this.board = await VirtualBoard.open(this.module);
    this.begun = performance.now();
    this.clock = setInterval(() => this.catchUp(), MOMENT);
  }

  /** How far the board's time is behind ours, in ms. */
  behind() {
    return performance.now() - this.begun - (this.board.now() * 1000) / this.board.hz;
  }

  catchUp() {
    const behind = this.behind();
    if (behind > SLEPT) this.begun += behind - MOMENT;
    if (behind > 0) this.board.run(this.board.now() + Math.floor((this.behind() * this.board.hz) / 1000));
  }

  /** Each byte takes its time on the line; so do the answers, which are here when they are whole. */
  write(bytes) {
    const { board } = this;
    this.catchUp();
    const answers = [];
    for (const byte of bytes) {
      board.run(board.now() + board.byteTime);
      answers.push(...board.receive(byte));
    }
    const line = (answers.length * board.byteTime * 1000) / board.hz;
    if (answers.length) setTimeout(() => this.clock && this.onbytes(Uint8Array.from(answers)), line - this.behind());
  }

  /** The edges of the last seconds, as GET /api/scope has them. */
  scope(seconds) {
    this.catchUp();
    return this.board.record(seconds);
  }

  async close() {
    clearInterval(this.clock);
    this.clock = null;
  }
}
