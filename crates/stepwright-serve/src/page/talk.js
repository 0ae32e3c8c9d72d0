// The conversation with the board, each line explained.

import { by, element } from "./dom.js";

/** The most lines. */
const KEPT = 400;

const list = by("lines");

function add(time, ...parts) {
  const follows = list.scrollHeight - list.scrollTop - list.clientHeight < 40;
  list.append(element("li", [element("time", time.toFixed(2)), ...parts]));
  while (list.children.length > KEPT) list.firstChild.remove();
  if (follows) list.scrollTop = list.scrollHeight;
}

/** A line and its answer. */
export function line(said) {
  const refused = said.answer === null || said.answer.startsWith("E");
  const answer = said.answer === null ? "" : `${said.answer.slice(0, 40)} `;
  const told = element("span", `→ ${answer}${said.answer_means}`, refused ? "no" : "answer");
  add(said.time, element("code", said.line || "␍"), element("span", [said.means.replaceAll("`", ""), " ", told]));
}

/** A note for users. */
export function note(said) {
  add(said.time, element("span", said.text, "note"));
}

/** Forgets all. */
export function clear() {
  list.replaceChildren();
}
