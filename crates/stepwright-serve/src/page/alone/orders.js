// Carries out what the views ask for, as `stepwright serve` does: a request becomes lines.

import { Declined } from "../server.js";
import { giveUp, home, notHomed } from "./homing.js";
import { shares } from "./line.js";

/** A board that hears nothing for this time brakes a run without end by itself, in ms. A page in the
 *  background is woken once a second. */
const LEASE = 2500;

/** How often an order is said whose lines were lost or damaged. */
const TRIES = 5;

/** From the start speed to the top speed, where no acceleration is given, in s. */
const RISE = 0.4;

const START = 50;
const TOP = 1000;

export const declined = (what, remedy, allowed) => new Declined({ what, allowed, do: remedy }, 409);

/** That a number is in its range. */
export function check(host, name, value) {
  const [low, high, unit] = host.range(name);
  if (typeof value === "number" && value >= low && value <= high) return value;
  throw declined(`${name} is ${value}`, undefined, `${low} to ${high} ${unit}`.trim());
}

/** The numbers of an order, by the request for it. */
export function limits(body, top) {
  const start_speed = body.start_speed ?? START;
  const normal = Math.min(1e8, Math.max(1, (top - start_speed) / RISE));
  const accel = body.accel ?? normal;
  return { top_speed: top, start_speed, accel, decel: body.decel ?? accel, jerk: body.jerk ?? 0 };
}

/** Steps of a travel that ends at a place. */
function distance(from, to) {
  if (Math.abs(to - from) > 0x7fffffff) throw declined(`from ${from} to ${to} is too far for one travel`);
  return to - from;
}

/** What each request does, by its path. `this` is the keeper. */
export const orders = {
  async move(body) {
    const from = await standsAt(this, body.axis);
    const steps = body.by ?? distance(from, body.to);
    return start(this, from, { axis: body.axis, steps, endless: 0, ...limits(body, body.top_speed ?? TOP) });
  },

  async line(body) {
    const [targets, absolute] = body.to ? [body.to, true] : [body.by, false];
    const [ways, from] = [[], new Map()];
    for (const [n, target] of targets.entries()) {
      if (target === null) continue;
      const at = await standsAt(this, n + 1);
      const steps = absolute ? distance(at, target) : target;
      if (!steps) continue;
      ways.push([n + 1, steps]);
      from.set(n + 1, at);
    }
    if (!ways.length) throw declined("no axis moves", "give an axis a distance, or a target where it does not stand");
    const orders = shares(ways, limits(body, body.top_speed ?? TOP));
    return startAll(this, orders.map((order) => ({ from: from.get(order.axis), order })));
  },

  async run(body) {
    const from = await standsAt(this, body.axis);
    const order = limits(body, Math.abs(body.speed));
    return start(this, from, { axis: body.axis, steps: Math.sign(body.speed), endless: 1, ...order });
  },

  async retarget(body) {
    const { session, host } = this;
    const watched = this.watched(body.axis);
    notHomed(watched);
    const lines = [];
    for (const [name, letter] of [["accel", "a"], ["decel", "d"]]) {
      if (body[name] !== undefined) lines.push(letter + Math.round(check(host, name, body[name])));
    }
    if (body.top_speed !== undefined) {
      const thousandths = Math.round(check(host, "top_speed", body.top_speed) * 1000);
      lines.push(thousandths % 1000 ? `m${thousandths}` : `t${thousandths / 1000}`);
    }
    if (body.to !== undefined || body.by !== undefined) {
      if (body.by === undefined && watched.from === null) throw declined(`where the travel of axis ${body.axis} began is not known`);
      const by = Math.round(body.by ?? distance(watched.from, body.to));
      lines.push(`@${by < 0 ? "-" : "+"}${Math.abs(by)}`);
    }
    if (!lines.length) throw declined("nothing to change", undefined, "one or more of by, to, top_speed, accel, decel");
    for (const line of lines) {
      // At rest the board would keep a change for later.
      if (!(await session.busy(body.axis))) throw declined(`axis ${body.axis} is at rest`, "a move or a run begins a travel");
      this.unplan(body.axis);
      if ((await session.askOf(body.axis, line)).kind !== "yes") throw await refused(this, line);
    }
    return lines;
  },

  async stop(body) {
    const axes = body.axis === undefined ? this.axes : [this.watched(body.axis)];
    if ((await this.session.askOf(body.axis ?? 0, "Z")).kind !== "yes") throw await refused(this, "Z");
    ended(this, axes);
    return ["Z"];
  },

  async kill() {
    if ((await this.session.ask("K")).kind !== "yes") throw await refused(this, "K");
    ended(this, this.axes);
    return ["K"];
  },

  async zero(body) {
    const watched = this.watched(body.axis);
    notHomed(watched);
    watched.home = null;
    await say(this, `I${body.axis}`, "is the axis still travelling?");
    watched.shiftOrigin();
    await this.lookAtAll();
    return [`I${body.axis}`];
  },

  async set(body) {
    const sheet = this.host.settings.find((one) => one.name === body.name);
    if (!sheet) throw declined(`no setting is called '${body.name}'`);
    const { min, max, unit } = sheet;
    if (!Number.isInteger(body.value) || body.value < min || body.value > max) {
      throw declined(`${body.name} is ${body.value}`, undefined, `${min} to ${max} ${unit}`.trim());
    }
    const line = `$${body.name}=${body.value}`;
    await say(this, line, "settings change while every axis rests");
    await this.learn();
    return [line];
  },

  async acknowledge() {
    await say(this, "!");
    await this.lookAtAll();
    return ["!"];
  },

  home(body) {
    return home(this, body);
  },
};

/** Where an axis stands that is to move. */
async function standsAt(keeper, axis) {
  notHomed(keeper.watched(axis));
  if (await keeper.session.busy(axis)) throw declined(`axis ${axis} is on its way`, "wait, stop it, or retarget it");
  const at = await keeper.session.restPosition(axis);
  if (at === null) {
    throw declined(`the position of axis ${axis} is uncertain`, "if it stands at a known place, or to go and find one, call it 0");
  }
  return at;
}

export const start = (keeper, from, order) => startAll(keeper, [{ from, order }]);

/** Starts axes together; the lines. */
async function startAll(keeper, begins) {
  const { host, session } = keeper;
  const [first, ...rest] = begins.map(({ order }) => {
    const { lines, wrong } = host.script(order);
    if (wrong) check(host, wrong, order[wrong]);
    return lines.slice(0, -1);
  });
  // What opens an order and what starts it is said once.
  const lines = [...first, ...rest.flatMap((own) => own.slice(own.lastIndexOf("PO") + 1)), "E"];
  if (begins[0].order.endless && session.info?.can?.includes("safety")) {
    lines.unshift(`L${LEASE}`);
    keeper.leased = true;
  }
  const began = keeper.time();
  await begin(keeper, begins, lines);
  for (const { from, order } of begins) {
    const watched = keeper.watched(order.axis);
    Object.assign(watched, { moving: true, runs: Boolean(order.endless), stop: null, from });
    watched.see(began, from);
    if (watched.home?.stage === "failed") watched.home = null;
    if (from !== null) keeper.plan(order, from, began);
  }
  return lines;
}

/** Starts axes together. An order that was lost on its way is said again, but only once the board has
 *  shown that nothing came of it. */
async function begin(keeper, begins, lines) {
  const { session } = keeper;
  const [{ order: { axis, steps, endless } }] = begins;
  for (let i = 0; i < TRIES; i++) {
    // PO is refused while the axis that is selected is busy, whichever.
    await session.select(axis);
    const failed = await session.play(lines);
    if (!failed) return;
    if (failed.answer) {
      const why = await session.why();
      // Noise may have made it another line.
      if (!["line", "sum"].includes(why?.refusal)) throw await refused(keeper, failed.line);
      continue;
    }
    await session.resync();
    const started = async () => {
      for (const { from, order } of begins) {
        if ((await session.busy(order.axis)) || (await session.restPosition(order.axis)) !== from) return true;
      }
      return !endless && steps === 0;
    };
    if (failed.line === "E" && (await started())) return;
  }
  throw declined(`${session.wire.name} did not understand the order`, "noise on the line? look at its cable");
}

/** The board's refusal of a line. */
async function refused(keeper, line, remedy) {
  const why = await keeper.session.why();
  const error = declined(`${keeper.session.wire.name} refused ${line}${why?.last ? `: ${why.last}` : ""}`, remedy);
  return Object.assign(error, { refusal: why?.refusal });
}

/** Says a line that is harmless twice. */
export async function say(keeper, line, remedy) {
  if ((await keeper.session.ask(line)).kind !== "yes") throw await refused(keeper, line, remedy);
}

/** From here on these axes need nobody: they end by themselves. */
function ended(keeper, axes) {
  axes.forEach((axis) => giveUp(keeper, axis, declined("stopped before 0 was found")));
  for (const axis of axes.filter((one) => one.moving)) {
    axis.runs = false;
    keeper.unplan(axis.axis);
  }
}
