// Moves a motor of a virtual board to 25 mm, with the host library as WebAssembly.

import { readFileSync } from "node:fs";
import { Host } from "../../stepwright-serve/src/page/alone/host.js";
import { PacedBoard } from "../../stepwright-serve/src/page/alone/paced.js";

const STEPS_PER_MM = 80;
const module = (name) => readFileSync(new URL(`../../stepwright-serve/src/page/${name}.wasm`, import.meta.url));

const host = await Host.open(module("host"));
await host.use(new PacedBoard(module("board"))); // or a wire of your own
const { ended } = await host.ask("move?wait=true", { axis: 1, to: 25 * STEPS_PER_MM });
console.log(`${ended.outcome} ${ended.axes[0].position}`); // reached 2000
await host.leave();
