// A virtual board in real time, as a wire.
//
// Nothing here needs a page: Node runs it too.

import { VirtualBoard } from "./virtual.js";

/** Between two updates of an idle board, in ms. */
const MOMENT = 10;

/** After sleep a computer catches up with at most this, in ms. */
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

  /** How far the board is behind real time, in ms. */
  behind() {
    return performance.now() - this.begun - (this.board.now() * 1000) / this.board.hz;
  }

  catchUp() {
    const behind = this.behind();
    if (behind > SLEPT) this.begun += behind - MOMENT;
    if (behind > 0) this.board.run(this.board.now() + Math.floor((this.behind() * this.board.hz) / 1000));
  }

  /** Bytes and answers take their time on the line; answers arrive whole. */
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

  /** The edges of the last seconds, as in GET /api/scope. */
  scope(seconds) {
    this.catchUp();
    return this.board.record(seconds);
  }

  async close() {
    clearInterval(this.clock);
    this.clock = null;
  }
}
