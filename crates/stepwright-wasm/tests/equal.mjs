// The module of the page, run by Node, against the hashes that the host has computed.
//
//   node equal.mjs plan.wasm moves.jsonl MOVES     MOVES of each law
//
// Ends with 0 if every travel has the same delays, and if no number can stop the planner.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join, dirname } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [file, moves, count] = process.argv.slice(2);
const page = join(dirname(fileURLToPath(import.meta.url)), "../../stepwright-serve/src/page");
const { LAWS, Planner } = await import(pathToFileURL(join(page, "planner.js")));

const module = await WebAssembly.compile(readFileSync(file));
// A panic would have to be imported.
assert.deepEqual(WebAssembly.Module.imports(module), []);
const planner = await Planner.open(readFileSync(file));

const same = LAWS.map(() => 0);
for (const line of readFileSync(moves, "utf8").trim().split("\n")) {
  const { law, numbers, hash } = JSON.parse(line);
  const plan = planner.plan(law, numbers);
  assert.equal(plan.refused, undefined, line);
  assert.equal(plan.hash.toString(16).padStart(16, "0"), hash, line);
  same[law]++;
}
assert.deepEqual(same, LAWS.map(() => Number(count)));

// Any numbers, also invalid ones: each travel is planned or refused with a reason.
let seed = 1n;
const random = () => (seed = (seed * 6364136223846793005n + 1442695040888963407n) & 0xffff_ffff_ffff_ffffn);
const odd = [NaN, Infinity, -Infinity, -0, 0, -1, 1e-300, 1e300, 2 ** 32, 0.5];
const view = new DataView(new ArrayBuffer(8));
let planned = 0;
for (let i = 0; i < 20_000; i++) {
  const numbers = planner.example();
  for (let times = Number(random() >> 62n); times >= 0; times--) {
    const at = Number((random() >> 33n) % BigInt(numbers.length));
    const [low, high] = planner.range(at);
    view.setBigUint64(0, random());
    numbers[at] = [odd[Number((random() >> 40n) % 10n)], view.getFloat64(0), low, high, low + (high - low) / 1e3][
      Number((random() >> 40n) % 5n)
    ];
  }
  // Not the longest travels, which run the same code.
  if (numbers[1] > 2_000) numbers[1] = 2_000;
  const plan = planner.plan(Number((random() >> 40n) % 8n), numbers);
  if (plan.refused) assert.ok(plan.refused.what && plan.refused.remedy);
  else planned++;
}
assert.ok(planned > 2_000 && planned < 18_000, `${planned} planned`);
console.log(`${same.reduce((a, b) => a + b)} travels are the same; ${planned} of 20000 odd ones were planned`);
