// The page without a server: it keeps a board itself, which the user chooses.

import { by, element } from "../dom.js";
import { keepBy } from "../server.js";
import { Host } from "./host.js";
import { Keeper } from "./keeper.js";
import { PacedBoard } from "./paced.js";
import { SerialWire } from "./serial.js";

async function fetched(name) {
  const answer = await fetch(new URL(name, import.meta.url));
  if (!answer.ok) throw new Error(`${name}: ${answer.status}`);
  return answer.arrayBuffer();
}

/** The list of boards, in place of the board's name. */
function chooser(keeper, module) {
  const list = element("select", new Option("virtual, in this page", "virtual"), { id: "ways" });
  if ("serial" in navigator) list.append(new Option("on a serial port…", "serial"));
  let chosen = "virtual";
  list.onchange = async () => {
    const wanted = list.value;
    list.disabled = true;
    try {
      const wire = wanted === "virtual" ? new PacedBoard(module) : new SerialWire(await navigator.serial.requestPort());
      document.body.classList.toggle("wired", wanted === "serial");
      chosen = wanted;
      await keeper.use(wire);
    } catch {
      // No port was chosen.
      list.value = chosen;
    }
    list.disabled = false;
  };
  by("board").after(element("label", ["Board ", list], "ways"));
}

/** Meets the virtual board; from then on the views ask this page. */
export async function begin() {
  document.body.classList.add("unserved");
  const [module, board] = await Promise.all([fetched("../host.wasm"), fetched("../board.wasm")]);
  const keeper = new Keeper(await Host.open(module));
  keepBy(keeper);
  chooser(keeper, board);
  await keeper.use(new PacedBoard(board));
  // For users of the console.
  by("board").keeper = keeper;
}
