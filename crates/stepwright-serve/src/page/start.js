// With a server the page drives the server's board; from other hosts a board of its own.

import { get } from "./server.js";

// A server that refuses has understood.
const served = await get("/api/board").then(() => true, (error) => error.status > 0);

try {
  if (!served) {
    const { begin } = await import("./alone/begin.js");
    await begin();
  }
  await import("./main.js");
} catch (error) {
  document.getElementById("notices").textContent = `The page could not be loaded (${error.message}): load it again.`;
}
