// With a server the page drives the server's board; from other hosts a board of its own.

import { get } from "./server.js";

try {
  // A server that refuses has understood.
  const served = await get("/api/board").then(() => true, (error) => {
    if (error.status === 401) throw error;
    return error.status > 0;
  });
  if (!served) {
    const { begin } = await import("./alone/begin.js");
    await begin();
  }
  await import("./main.js");
} catch (error) {
  document.body.classList.add("unreached");
  document.getElementById("notices").textContent = error.status === 401
    ? "This server asks for a token: open the whole address that `stepwright serve` has printed, with #token=…"
    : `The page could not be loaded (${error.message}): load it again.`;
}
