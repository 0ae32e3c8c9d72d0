// The way to the server: requests, and the WebSocket that tells what the board does.
//
// The page asks nothing that a program could not: /api/openapi.json describes it all.

import { Declined } from "./declined.js";

/** The token of a server beyond loopback: behind the # of the address, which stays here. */
const token = (() => {
  const said = new URLSearchParams(location.hash.slice(1)).get("token");
  if (said) {
    sessionStorage.setItem("token", said);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token");
})();

/** The key of who controls, once it was given. */
let key = null;
/** The number of the hand whose key it is. */
export let hand = null;

/** What keeps a board within this page, where there is no server: it is asked the same. */
let keeper = null;

/** From now on this keeper is asked. */
export function keepBy(one) {
  keeper = one;
  hand = 1;
}

async function ask(path, options = {}) {
  if (keeper) return keeper.ask(path, options.body && JSON.parse(options.body));
  const headers = { ...options.headers };
  if (token) headers.Authorization = `Bearer ${token}`;
  if (key) headers["Stepwright-Control"] = key;
  let answer;
  try {
    answer = await fetch(path, { ...options, headers });
  } catch {
    throw new Declined({ what: "the server does not answer", do: "is `stepwright serve` still running?" }, 0);
  }
  if (answer.ok && options.raw) return answer.arrayBuffer();
  const body = await answer.json();
  if (!answer.ok) throw new Declined(body, answer.status);
  return body;
}

/** A record of GET /api/scope as a file, by the ending of its name: vcd, csv, mcap. */
export const fileOf = (ending, record) =>
  ask(`/api/scope/file?ending=${ending}`, { raw: true, ...posted(record) });

const posted = (body) => ({ method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

/** GET. */
export const get = (path) => ask(path);

/** POST. What is declined is thrown. */
export const post = (path, body = {}) => ask(path, posted(body));

/** Takes control; also from another page, if that is wanted. */
export async function take(over) {
  const given = await post("/api/control", { take_over: over });
  ({ key, hand } = given);
}

/** Gives control back. */
export async function release() {
  await post("/api/control/release");
  key = hand = null;
}

/** Between two beats, in ms: a beat answers a frame, so a page in the background has them too. */
const BEAT = 200;

/** Follows the board: `hear(message)` for each message, `lost()` while the server is gone. */
export function follow(hear, lost) {
  if (keeper) return keeper.follow(hear);
  let socket;
  let beaten = 0;
  let wanted = false;
  /** The key that this page had last: with it a seat is kept for it. */
  let control = null;
  const open = () => {
    const query = new URLSearchParams({ ...(token && { token }), ...(control && { control }) });
    socket = new WebSocket(`ws://${location.host}/api/live?${query}`);
    socket.onopen = () => wanted && socket.send(JSON.stringify({ questions: true }));
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      const now = performance.now();
      if (key && message.type === "state" && now - beaten >= BEAT) {
        beaten = now;
        socket.send(JSON.stringify({ beat: key }));
      }
      hear(message);
    };
    socket.onclose = () => {
      control = key ?? control;
      // A server that was started again knows no key of the old one.
      key = hand = null;
      lost();
      setTimeout(open, 1000);
    };
  };
  open();
  return {
    /** Whether the questions to the board are wanted as well. */
    questions(on) {
      wanted = on;
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ questions: on }));
    },
  };
}
