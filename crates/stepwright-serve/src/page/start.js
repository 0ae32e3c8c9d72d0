// With a server behind it the page drives a board; from any other host it plans.

import { get } from "./server.js";

// What a server declines, it has understood.
const served = await get("/api/board").then(() => true, (error) => error.status > 0);

if (served) {
  await import("./main.js");
} else {
  const { PlanView } = await import("./plan.js");
  document.body.classList.add("alone", "unserved");
  document.getElementById("plan").classList.add("shown");
  history.replaceState(null, "", "#plan");
  new PlanView((error) => {
    document.getElementById("notices").textContent = error.message;
  });
}
