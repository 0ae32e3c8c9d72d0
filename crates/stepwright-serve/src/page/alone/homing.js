// Finds 0 by a limit switch, as `stepwright home` does.
//
//   seek ──► 0, back-off ──► approach slowly ──► 0, leave ──► done
//     switch closes: halt      switch closes: halt, 0 is here
//
// The halt from the speed of the seek may lose steps, so the place that counts is that of the slow
// approach.

import { Lost } from "./session.js";
import { declined, limits, say, start } from "./orders.js";

/** The board takes no order towards a switch until it has stopped bouncing: 250 ms at most. */
const OPENS = 300;

const WORDS = {
  seek: "seeks its switch",
  "back-off": "backs off from its switch",
  approach: "approaches its switch slowly",
  leave: "leaves its switch: 0 is there",
};

const towards = (leg) => leg === "seek" || leg === "approach";

/** That an axis is not being homed: then nothing else is ordered. */
export function notHomed(watched) {
  if (watched.homing) throw declined(`axis ${watched.axis} is being homed`, "wait, or stop it");
}

/** A whole number of steps, from 1 on. */
function steps(name, value) {
  if (value === undefined) throw declined(`\`${name}\` is missing: how far the switch may be`, "give a little more than the axis can travel");
  if (Number.isInteger(value) && value >= 1 && value <= 0x7fffffff) return value;
  throw declined(`${name} is ${value}`, undefined, "1 to 2147483647 steps");
}

/** Begins to home an axis. */
export async function home(keeper, body) {
  const watched = keeper.watched(body.axis);
  notHomed(watched);
  if (await keeper.session.busy(body.axis)) throw declined(`axis ${body.axis} is on its way`, "wait, or stop it");
  const setting = (name) => keeper.board.settings.find((one) => one.name === name)?.value ?? 0;
  const [bit, switches] = [1 << (body.axis - 1), setting("switches")];
  if (!(switches & bit)) {
    const remedy = `if there is one, the setting \`switches\` says so: ${switches | bit} (1 X, 2 Y, 4 Z, added up)`;
    throw declined(`${keeper.board.name} knows of no limit switch of axis ${body.axis}`, remedy);
  }
  const info = await keeper.session.why();
  const way = setting("switch-forward") & bit ? 1 : -1;
  watched.homing = {
    way,
    away: -way * steps("back_off", body.back_off ?? 50),
    within: steps("within", body.within),
    seek: limits(body, body.speed ?? 500),
    slow: limits(body, body.slow ?? 50),
    safeStart: setting("safe-start") === 1,
    // Whether nothing had gone wrong before it.
    clean: !info || (info.late === 0 && info.errors.length === 0),
  };
  try {
    return await go(keeper, watched, "seek");
  } catch (error) {
    watched.homing = watched.home = null;
    throw error;
  }
}

/** Begins a leg. */
async function go(keeper, watched, leg) {
  const { homing, axis } = watched;
  const order = { axis, ...(leg === "approach" ? homing.slow : homing.seek) };
  Object.assign(order, towards(leg) ? { steps: homing.way, endless: 1 } : { steps: homing.away, endless: 0 });
  watched.home = { stage: leg, words: WORDS[leg], do: null };
  Object.assign(homing, { leg, until: null, braked: false, again: false });
  try {
    const lines = await start(keeper, await keeper.session.restPosition(axis), order);
    if (towards(leg)) homing.until = performance.now() + (homing.within / order.top_speed) * 1000;
    return lines;
  } catch (error) {
    if (!towards(leg) || error.refusal !== "fault") throw error;
  }
  // The switch is closed before the leg to it: already, or still.
  if (leg === "seek") return zero(keeper, watched, "back-off");
  homing.openBy ??= performance.now() + OPENS;
  if (performance.now() > homing.openBy) {
    throw declined(`the switch of axis ${axis} is closed still, ${Math.abs(homing.away)} steps away from it`, "back off further, or look at the switch, its wiring and switch-high");
  }
  homing.again = true;
  return [];
}

/** Calls the place 0, and begins the leg behind that. */
async function zero(keeper, watched, leg) {
  await say(keeper, `I${watched.axis}`);
  watched.shiftOrigin();
  return go(keeper, watched, leg);
}

/** Goes on with what is being homed. */
export async function goOn(keeper) {
  for (const watched of keeper.axes.filter((axis) => axis.homing)) {
    // A stop is waited for: it goes first.
    if (keeper.jobs[0]?.urgent) return;
    try {
      await next(keeper, watched);
    } catch (error) {
      if (error instanceof Lost) throw error;
      giveUp(keeper, watched, error);
    }
  }
}

async function next(keeper, watched) {
  const { homing, axis } = watched;
  const { leg } = homing;
  if (homing.again) return go(keeper, watched, leg);
  if (watched.moving) {
    if (homing.until === null || homing.braked || performance.now() < homing.until) return;
    homing.braked = true;
    return keeper.session.askOf(axis, "Z");
  }
  const position = await keeper.session.restPosition(axis);
  const info = await keeper.session.why();
  keeper.unplan(axis);
  if (!towards(leg)) {
    if (position !== homing.away) throw declined("the axis did not get away from its switch", "look what has stopped it");
    return leg === "leave" ? done(keeper, watched, info) : go(keeper, watched, "approach");
  }
  if (homing.braked) {
    throw declined(`no switch of axis ${axis} within ${homing.within} steps`, "is it wired, and on this side (switch-forward)? Else look further");
  }
  const stop = info?.stops[axis - 1];
  if (stop?.name !== "switch") throw declined(stop ? `stopped by ${stop.words}` : "the axis rests, and its switch has not stopped it");
  if (homing.safeStart) await say(keeper, "!");
  return zero(keeper, watched, leg === "seek" ? "back-off" : "leave");
}

/** It is homed. That its switch has stopped it was meant: the board forgets that, unless something
 *  else has gone wrong as well. */
async function done(keeper, watched, info) {
  const others = info?.stops.some((stop, n) => n !== watched.axis - 1 && stop?.name === "switch");
  const only = info?.late === 0 && info.errors.map((error) => error.name).join() === "switch";
  if (watched.homing.clean && only && !others) await say(keeper, "!");
  watched.homing = null;
  watched.home = { stage: "done", words: "homed: 0 is where its switch closes", do: null };
  await keeper.askWhy();
}

/** The homing of an axis, if it is on one, has come to nothing, for this reason. */
export function giveUp(keeper, watched, why) {
  if (!watched.homing) return;
  watched.homing = null;
  watched.home = { stage: "failed", words: why.message, do: null };
  keeper.note(`axis ${watched.axis} is not homed: ${why.message}`);
}
