// The conversation with the board, each line explained.

import { element } from "./dom.js";

/** Lines that are kept. */
const KEPT = 400;

const list = document.getElementById("lines");

function add(time, ...parts) {
  const follows = list.scrollHeight - list.scrollTop - list.clientHeight < 40;
  const row = element("li");
  row.append(element("time", time.toFixed(2)), ...parts);
  list.append(row);
  while (list.children.length > KEPT) list.firstChild.remove();
  if (follows) list.scrollTop = list.scrollHeight;
}

/** A line and its answer. */
export function line(said) {
  const refused = said.answer === null || said.answer.startsWith("E");
  const means = element("span", said.means.replaceAll("`", ""));
  const answer = said.answer === null ? "" : `${said.answer.slice(0, 40)} `;
  means.append(" ", element("span", `→ ${answer}${said.answer_means}`, refused ? "no" : "answer"));
  add(said.time, element("code", said.line || "␍"), means);
}

/** Something that people should know. */
export function note(said) {
  add(said.time, element("span", said.text, "note"));
}

/** Forgets it all. */
export function clear() {
  list.replaceChildren();
}
