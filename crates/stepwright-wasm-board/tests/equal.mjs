// The virtual board of the page, run by Node, against the board of the command: the same bytes at the
// same times get the same answers, and move the same pins in the same ticks.
//
//   node equal.mjs board.wasm STEPWRIGHT
//
// Ends with 0 if all is equal, and if no byte and no number can stop it.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [file, stepwright] = process.argv.slice(2);
const page = join(dirname(fileURLToPath(import.meta.url)), "../../stepwright-serve/src/page/alone");
const { VirtualBoard } = await import(pathToFileURL(join(page, "virtual.js")));

const bytes = readFileSync(file);
// A panic would have to be imported.
assert.deepEqual(WebAssembly.Module.imports(await WebAssembly.compile(bytes)), []);

let seed = 7n;
const random = (below) => {
  seed = (seed * 6364136223846793005n + 1442695040888963407n) & 0xffff_ffff_ffff_ffffn;
  return Number((seed >> 33n) % BigInt(below));
};
/** A line feed is ignored by the protocol, and takes its time. */
const wait = (ms) => "\n".repeat(Math.round(ms * 11.52));

/** An order, as a host gives it. */
function order(axis, steps, { endless = 0 } = {}) {
  const of = axis > 1 ? `A${axis}\r` : "";
  const jerk = random(2) * random(400_000);
  const speeds = `s${random(300)}\rt${200 + random(6000)}\ra${1000 + random(20_000)}\rd${1000 + random(20_000)}\r`;
  const travel = `${endless ? "g" : "G"}${steps < 0 ? "-" : "+"}${endless ? "" : Math.abs(steps)}`;
  return `${of}PO\r${of}${speeds}${jerk ? `j${jerk}\r` : ""}${travel}\rE\r`;
}

const conversations = [
  "PO\rS5\rT100\rR200\rG+4000\rE\rF\rV1\r?\r$\r",
  order(1, 3000) + order(2, -2000) + order(3, 500) + wait(300) + "V1\rV2\rV3\rA0\rF\rZ\r",
  order(1, 1, { endless: 1 }) + wait(400) + "t700\ra9000\r" + wait(300) + "@+100\r" + wait(100) + "V1\rA1\rZ\r" + wait(500) + "?\r",
  order(2, -1, { endless: 1 }) + wait(300) + "K\rV2\r?\rI2\rV2\r!\r?\r",
  // The switch of the page's board stays unset: the command's board has none.
  "$idle-ms=200\r$pulse-us=7\r$reverse=2\r$\r" + order(2, 300) + wait(900),
];
for (let n = 0; n < 40; n++) {
  const said = Array.from({ length: 6 }, () => {
    const axis = 1 + random(3);
    return [
      () => order(axis, random(4000) - 2000),
      () => `A${axis}\r@${"+-"[random(2)]}${random(4000)}\r`,
      () => `A${axis}\rt${1 + random(5000)}\r`,
      () => `A${random(4)}\rZ\r`,
      () => `V${axis}\rF\r`,
      () => wait(random(400)),
    ][random(6)]();
  });
  conversations.push(said.join(wait(random(100))));
}

const folder = mkdtempSync(join(tmpdir(), "stepwright-board-"));

/** The answers of the command's board, and its edges: [ticks, axis from 0, pin, level]. */
function commanded(conversation) {
  const vcd = join(folder, "edges.vcd");
  const ran = spawnSync(stepwright, ["board", "--stdio", "--fast", "--vcd", vcd], { input: conversation, encoding: "latin1" });
  assert.equal(ran.status, 0, ran.stderr);
  let time = 0;
  const edges = [];
  const changes = readFileSync(vcd, "utf8").split("$dumpvars")[1].split("$end\n").at(-1);
  for (const line of changes.trim().split("\n")) {
    if (line[0] === "#") {
      // In 100 ps; a tick has 625 of them.
      time = Number(line.slice(1)) / 625;
    } else {
      const pin = line.charCodeAt(1) - 97;
      edges.push([time, pin >> 1, pin % 2 ? "dir" : "step", line[0] === "1"]);
    }
  }
  return { answers: ran.stdout, edges };
}

let steps = 0;
for (const conversation of conversations) {
  const { answers, edges } = commanded(conversation);
  const board = await VirtualBoard.open(bytes);
  let said = "";
  for (const byte of Buffer.from(conversation, "latin1")) {
    board.run(board.now() + board.byteTime);
    said += String.fromCharCode(...board.receive(byte));
  }
  while (board.busy()) board.run(board.now() + board.hz / 100);
  const [first] = conversation.split("\n");
  assert.equal(said, answers, first);
  const mine = board.edges().filter(([, , pin]) => pin !== "enable");
  const last = edges.at(-1)?.[0] ?? 0;
  assert.deepEqual(mine.filter(([time]) => time <= last), edges.filter(([time]) => time <= last), first);
  assert.equal(mine.length, edges.length, first);
  // The shafts are where the edges have led them.
  const shaft = [0, 0, 0];
  const forward = [false, false, false];
  for (const [, axis, pin, level] of mine) {
    if (pin === "dir") forward[axis] = level;
    else if (level) {
      shaft[axis] += forward[axis] ? 1 : -1;
      steps++;
    }
  }
  assert.deepEqual(board.shafts(), shaft);
}
rmSync(folder, { recursive: true });
// Some of the steepest orders are refused.
assert.ok(steps > 30_000, `${steps}`);

// Any bytes: each line is answered or refused.
const board = await VirtualBoard.open(bytes);
for (let n = 0; n < 200_000; n++) {
  const byte = random(3) ? "PSTRGEFVZKA@tadjgILs?!$+-0123456789\r".charCodeAt(random(36)) : random(256);
  board.receive(byte);
  if (n % 16 === 0) board.run(board.now() + random(200_000));
}
console.log(`${conversations.length} conversations, ${steps} steps: the same as the command's`);
