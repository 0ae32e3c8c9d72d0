// The link to the server: requests, and the WebSocket with the board's state.
//
// The page asks nothing that a program can't: /api/openapi.json describes it all.

import { Declined } from "./declined.js";

/** Without a server. */
export const GONE = new Declined({ what: "the server does not answer", do: "is `stepwright serve` still running?" }, 0);

/** The token of a server beyond loopback: after the # of the address, which stays here. */
const token = (() => {
  const said = new URLSearchParams(location.hash.slice(1)).get("token");
  if (said) {
    sessionStorage.setItem("token", said);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token");
})();

/** The key of control, once it was given. */
let key = null;
/** The number of the hand with this key. */
export let hand = null;

/** Keeps a board within this page, if there is no server. */
let keeper = null;

/** Asks this keeper from now on. */
export function keepBy(one) {
  keeper = one;
  hand = 1;
}

async function ask(path, options = {}) {
  if (keeper) return keeper.ask(path, options.body && JSON.parse(options.body));
  const headers = { ...options.headers };
  if (token) headers.Authorization = `Bearer ${token}`;
  if (key) headers["Stepwright-Control"] = key;
  const answer = await fetch(path, { ...options, headers }).catch(() => {
    throw GONE;
  });
  if (answer.ok && options.raw) return answer.arrayBuffer();
  const body = await answer.json();
  if (!answer.ok) throw new Declined(body, answer.status);
  return body;
}

/** A record of GET /api/scope as a file with this ending: vcd, csv, mcap. */
export const fileOf = (ending, record) =>
  ask(`/api/scope/file?ending=${ending}`, { raw: true, ...posted(record) });

const posted = (body) => ({ method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

/** GET. */
export const get = (path) => ask(path);

/** POST. Throws refusals. */
export const post = (path, body = {}) => ask(path, posted(body));

/** Takes control, from another page too if `over`. */
export async function take(over) {
  const given = await post("/api/control", { take_over: over });
  ({ key, hand } = given);
}

/** Gives control back. */
export async function release() {
  await post("/api/control/release");
  key = hand = null;
}

/** Between two beats, in ms. Beats answer frames, so a page in the background has them too. */
const BEAT = 200;

/** Follows the board: `hear(message)` for each message, `lost()` when the server is gone. */
export function follow(hear, lost) {
  if (keeper) return keeper.follow(hear);
  let socket;
  let beaten = 0;
  let wanted = false;
  /** The last key of this page: it keeps a seat for the page. */
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
      // A restarted server does not know the old key.
      key = hand = null;
      lost();
      setTimeout(open, 1000);
    };
  };
  open();
  return {
    /** Whether questions to the board are wanted too. */
    questions(on) {
      wanted = on;
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ questions: on }));
    },
  };
}
