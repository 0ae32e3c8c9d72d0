// The host library as WebAssembly, run by Node: it homes, tells why an order is refused, brakes motors
// when a page leaves, writes files for other readers, and no byte and no request stops it.
//
//   node stands.mjs

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

const page = new URL("../../stepwright-serve/src/page/", import.meta.url);
const { Host } = await import(new URL("alone/host.js", page));
const { PacedBoard } = await import(new URL("alone/paced.js", page));
const module = (name) => readFileSync(new URL(`${name}.wasm`, page));

let seed = 7n;
const random = (below) => {
  seed = (seed * 6364136223846793005n + 1442695040888963407n) & 0xffff_ffff_ffff_ffffn;
  return Number((seed >> 33n) % BigInt(below));
};

/** A host that has met the virtual board, and its messages. */
async function met() {
  const [host, board, told] = [await Host.open(module("host")), new PacedBoard(module("board")), []];
  host.told = (message) => told.push(message);
  await host.use(board);
  return { host, board, told };
}

{
  const { host, board, told } = await met();
  await host.ask("set", { name: "switches", value: 1 });
  // The switch of its machine closes at −1000.
  const homed = await host.ask("home?wait=true", { axis: 1, speed: 2000, slow: 500, within: 3000 });
  assert.deepEqual([homed.ended.outcome, homed.ended.axes[0].position], ["reached", 50]);
  assert.ok(Math.abs(board.board.shafts()[0] + 950) <= 5, `${board.board.shafts()}`);
  await assert.rejects(host.ask("move", { axis: 1, by: 1, top_speed: 5e6 }), /Allowed: 0.001 to 1000000 steps/);
  await assert.rejects(host.ask("move", { axis: 1, by: 400_000, top_speed: 9e5, accel: 9e6 }), /faster than the board can step/);
  await assert.rejects(host.ask("move", { axis: 4, by: 1 }), /Allowed: 1 to 3/);
  // A run is braked when the page leaves: the board rests soon, before its lease of 2.5 s has ended.
  await host.ask("run", { axis: 2, speed: 800 });
  assert.ok(told.some((message) => message.type === "plan" && message.axis === 2));
  await host.leave();
  board.board.run(board.board.now() + 2 * board.board.hz);
  assert.ok(!board.board.busy());
}

// Files of a record: three edges of a pin.
{
  const { host } = await met();
  const record = {
    source: "pins", words: "w", hz: 16_000_000, begin: 0, end: 3200,
    signals: [{ name: "step1", axis: 1, pin: "step", level: false, edges: [16, 32, 1600] }],
  };
  const text = (ending) => new TextDecoder().decode(host.file(ending, record));
  assert.equal(text("csv"), "time_us,step1\n0.0000,0\n1.0000,1\n3.0000,0\n103.0000,1\n");
  assert.ok(text("vcd").includes("$var wire 1 ! step1 $end"));
  const magic = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
  const mcap = host.file("mcap", record);
  assert.deepEqual([[...mcap.slice(0, 8)], [...mcap.slice(-8)]], [magic, magic]);
  assert.throws(() => host.file("txt", record), /no txt/);
  assert.throws(() => host.file("csv", { hz: -1 }), /no csv/);
  await host.leave();
}

// Noise instead of a board, and senseless requests: each is answered.
{
  const host = await Host.open(module("host"));
  const wire = { name: "noise", open: async () => {}, write: () => {}, close: async () => {} };
  host.wire = wire;
  wire.onbytes = (bytes) => host.turn(1, bytes);
  host.met = () => {};
  host.turn(3, "noise");
  const names = ["move", "line", "run", "home", "retarget", "stop", "kill", "zero", "set", "acknowledge", "x", ""];
  const odd = [NaN, Infinity, -1, 0, 0.5, 1, 3, 2 ** 31, 2 ** 53, 1e300, "1", null, [], {}, true];
  const fields = ["axis", "by", "to", "speed", "top_speed", "accel", "jerk", "name", "value", "within"];
  const asked = [];
  for (let n = 0; n < 20_000; n++) {
    wire.onbytes(Uint8Array.from({ length: random(20) }, () => (random(3) ? "YERB-0123456789 stepwright\r".charCodeAt(random(27)) : random(256))));
    const body = Object.fromEntries(Array.from({ length: random(4) }, () => [fields[random(10)], odd[random(15)]]));
    if (n % 10 === 0) asked.push(host.ask(names[random(12)], body).then(() => "done", (error) => error.status));
  }
  host.turn(5, "pulled");
  const left = new Promise((left) => (host.left = left));
  host.turn(6);
  await left;
  clearTimeout(host.again);
  clearTimeout(host.timer);
  const answers = await Promise.all(asked);
  assert.ok(answers.every((answer) => answer === "done" || (answer >= 400 && answer < 600)), `${answers}`);
  console.log(`homed, files written, ${answers.length} odd requests answered`);
}
