// Paths without a server: the examples, as drawn by `stepwright serve`.

import { Declined } from "../declined.js";
import { once } from "../dom.js";

const PLAYER =
  "This page has the drawings of the examples. `stepwright serve` draws any file, also while its text is changed, and runs it.";

/** Files and their drawings; a test compares them with the command's. */
const examples = once(async () => {
  try {
    return await (await fetch(new URL("./paths.json", import.meta.url))).json();
  } catch {
    throw new Declined({ what: "the drawings could not be loaded", do: "is the network on?" }, 503);
  }
});

/** The answers of /api/path and below it. */
export async function paths(name, body) {
  const known = await examples();
  if (name === "path/examples") return { examples: known.map(({ file }) => file), player: PLAYER, job_endings: [".nc"], port: null, board: null };
  if (name === "path" && !body) return null;
  const found = name === "path" && known.find(({ file }) => file.text === body.text);
  if (found) return found.drawing;
  throw new Declined({ what: "this page draws the examples alone", do: "`stepwright serve` draws any file" }, 422);
}
