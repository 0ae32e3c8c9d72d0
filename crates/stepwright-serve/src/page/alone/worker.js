// A virtual board in a worker, in real time.
//
//   in:  { module } its bytes, first · { bytes } of the line · { scope: seconds } · { shafts: true }
//   out: { ready } · { bytes } of the line · { record } · { shafts }

import { VirtualBoard } from "./virtual.js";

/** Between two moments of a board that hears nothing, in ms. */
const MOMENT = 10;

/** An answer may be here so much before its time, in ms. */
const AHEAD = 1;

/** A machine that has slept does not catch up with more than this, in ms. */
const SLEPT = 1000;

let board = null;
/** When the board was switched on, by the clock of the worker. */
let begun = 0;
/** Answers on their way, and when each is here, in ticks. */
let coming = [];
let waiting = null;

const ticks = (ms) => Math.floor((ms * board.hz) / 1000);
const present = () => ticks(performance.now() - begun);

function catchUp() {
  const behind = ((present() - board.now()) / board.hz) * 1000;
  if (behind > SLEPT) begun += behind - MOMENT;
  board.run(Math.max(board.now(), present()));
}

function hear(bytes) {
  catchUp();
  for (const byte of bytes) {
    board.run(board.now() + board.byteTime);
    for (const answer of board.receive(byte)) {
      coming.push([Math.max(coming.at(-1)?.[0] ?? 0, board.now()) + board.byteTime, answer]);
    }
  }
  answer();
}

/** Sends what is here by now; the rest in its time. */
function answer() {
  const until = present() + ticks(AHEAD);
  const count = coming.findIndex(([time]) => time > until);
  const here = coming.splice(0, count < 0 ? coming.length : count);
  if (here.length) postMessage({ bytes: Uint8Array.from(here, ([, byte]) => byte) });
  clearTimeout(waiting);
  if (coming.length) waiting = setTimeout(answer, Math.max(1, ((coming.at(-1)[0] - until) / board.hz) * 1000));
}

onmessage = async ({ data }) => {
  if (data.module) {
    board = await VirtualBoard.open(data.module);
    begun = performance.now();
    setInterval(catchUp, MOMENT);
    postMessage({ ready: true });
  } else if (data.bytes) {
    hear(data.bytes);
  } else if (data.scope) {
    catchUp();
    postMessage({ record: board.record(data.scope) });
  } else if (data.shafts) {
    postMessage({ shafts: board.shafts() });
  }
};
