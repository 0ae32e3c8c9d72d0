// Keeps the conversation with a board from within the page, in the place of `stepwright serve`:
// the views ask it what they would ask the server, and hear from it what they would hear.
//
//   use(wire) ─► meet ─► attend: orders, looks ──► lost ─► meet again ─► attend …

import { LAWS, NUMBERS } from "../planner.js";
import { Declined } from "../server.js";
import { giveUp, goOn } from "./homing.js";
import { Machine, machineForm } from "./machine.js";
import { orders } from "./orders.js";
import { paths } from "./paths.js";
import { Lost, Session } from "./session.js";
import { Watched } from "./watched.js";

/** Between two looks at axes that move, that rest, and at everything, in ms. */
const LOOK = 20;
const IDLE = 100;
const ALL = 500;

/** Between two attempts to meet a board that is gone, in ms. */
const AGAIN = 500;

/** A run without end is planned this far ahead, in s. */
const LONG = 3600;

/** Points of a plan that are told, about; and steps that are walked for it, at most: some 10 ms. */
const POINTS = 200;
const WALKED = 100_000;

/** What goes before whatever waits. */
const URGENT = ["stop", "kill"];

const later = (ms) => new Promise((on) => setTimeout(on, ms));

export class Keeper {
  /** `host` is the host's half of the line, `planner` the ramp laws. */
  constructor(host, planner) {
    this.host = host;
    this.planner = planner;
    this.begun = performance.now();
    this.jobs = [];
    this.axes = [];
    this.machine = new Machine();
    this.board = null;
    this.sheet = 0;
    this.connected = false;
    this.trouble = null;
    this.leased = false;
    this.asked = false;
    this.told = () => {};
  }

  /** Seconds since the page began. */
  time() {
    return Math.round((performance.now() - this.begun) * 1000) / 1e6;
  }

  // What the views call.

  /** A request, as to the server. */
  async ask(path, body) {
    const [, name, query] = /^\/api\/([a-z/]*)\??(.*)$/.exec(path);
    if (name === "board") return this.board;
    if (name === "state") return this.state();
    if (name === "scope") return this.scope(Number(new URLSearchParams(query).get("seconds")));
    if (name.startsWith("path")) return paths(name, body);
    if (name.startsWith("control")) return { hand: 1, key: "page", lease_ms: 2500 };
    if (!orders[name]) throw new Declined({ what: `this page has no ${name}`, do: "`stepwright serve` has" }, 404);
    return this.wish(name, body ?? {});
  }

  /** Has `hear(message)` hear what happens. */
  follow(hear) {
    this.told = hear;
    this.publish();
    return { questions: (on) => (this.asked = on) };
  }

  async scope(seconds) {
    if (this.session?.wire.scope) return this.session.wire.scope(seconds);
    throw new Declined({ what: "nobody sees the edges of this board", do: "`stepwright serve` shows the planned ones" }, 404);
  }

  wish(name, body) {
    const urgent = URGENT.includes(name);
    return new Promise((take, fail) => {
      if (!this.connected) throw new Declined({ what: this.trouble?.what ?? "no board was met yet", do: this.trouble?.do }, 503);
      if (urgent) {
        const stopped = this.jobs.filter((job) => !job.urgent);
        this.jobs = this.jobs.filter((job) => job.urgent);
        const why = { what: "a stop came before this order was given", do: "give it again if it is still wanted" };
        stopped.forEach((job) => job.fail(new Declined(why, 409)));
      }
      this.jobs.push({ name, body, urgent, take, fail });
      this.come?.();
    });
  }

  // The board.

  /** Leaves the board that there is, and keeps the one at the end of this wire. */
  async use(wire) {
    await this.leave();
    this.wire = wire;
    this.kept = this.keep(wire);
  }

  /** Brakes what moves, and lets go of the board. */
  async leave() {
    const { wire } = this;
    if (!wire) return;
    this.wire = null;
    this.come?.();
    await this.kept;
    if (this.connected && this.axes.some((axis) => axis.moving)) {
      await this.session.askOf(0, "Z").catch(() => {});
    }
    if (this.connected && this.leased) await this.session.ask("L0").catch(() => {});
    Object.assign(this, { connected: false, leased: false, axes: [] });
    await wire.close();
  }

  async keep(wire) {
    for (let first = true; this.wire === wire; first = false) {
      try {
        await wire.open();
        this.session = new Session(this.host, wire, (said) => this.heard(said));
        await this.session.meet();
        this.axes = [];
        await this.learn();
        this.connected = true;
        this.trouble = null;
        // Nobody has held meanwhile what ran.
        if (!first) await orders.stop.call(this, {});
        if (!first) this.note(`${wire.name} is back`);
        await this.lookAtAll();
        await this.attend(wire);
        return;
      } catch (error) {
        this.lose(wire, error);
      }
      await wire.close();
      await later(AGAIN);
    }
  }

  /** Does what there is to do, as long as this wire is kept. */
  async attend(wire) {
    let [looked, all] = [performance.now(), performance.now()];
    while (this.wire === wire) {
      const pause = this.axes.some((axis) => axis.moving || axis.homing) ? LOOK : IDLE;
      const job = await this.next(pause - (performance.now() - looked));
      if (this.session.gone) throw this.session.lost();
      if (job) await this.carryOut(job);
      if (this.jobs[0]?.urgent || (!job && performance.now() - looked < pause - 1)) continue;
      looked = performance.now();
      if (looked - all >= ALL || job) {
        all = looked;
        await this.lookAtAll();
      } else {
        await this.look();
      }
      await goOn(this);
      this.publish();
    }
  }

  /** Waits for a job, at most so long, in ms. */
  async next(limit) {
    if (!this.jobs.length && limit > 0) {
      await new Promise((come) => {
        const timer = setTimeout(come, limit);
        this.come = () => (clearTimeout(timer), come());
      });
    }
    return this.jobs.shift();
  }

  async carryOut({ name, body, take, fail }) {
    try {
      const lines = await orders[name].call(this, body);
      this.publish();
      take({ lines });
    } catch (error) {
      fail(error instanceof Lost ? new Declined({ what: error.message, do: "a motor may be moving: look at it" }, 503) : error);
      if (error instanceof Lost) throw error;
    }
  }

  lose(wire, error) {
    // What is no loss of the line is a fault of this page, and is shown as it is.
    if (!(error instanceof Lost) && this.connected) console.error(error);
    const what = error instanceof Lost ? error.message : `${wire.name}: ${error.message}`;
    const remedy = "look at its cable and its power; it is met again when it is back";
    if (this.connected) this.note(what);
    Object.assign(this, { connected: false, leased: false, trouble: { what, do: remedy } });
    this.axes.forEach((axis) => giveUp(this, axis, new Declined({ what, do: remedy }, 503)));
    this.jobs.splice(0).forEach((job) => job.fail(new Declined({ what, do: remedy }, 503)));
    this.publish();
  }

  /** Asks the board what it is. */
  async learn() {
    const { info, wire } = this.session;
    const listed = info && (await this.session.once("$"));
    const values = listed?.values ?? [];
    const settings = this.host.settings.flatMap((sheet, at) => (values[at] >= 0 ? [{ ...sheet, value: values[at] }] : []));
    const switches = settings.find((one) => one.name === "switches")?.value ?? 0;
    const axes = Array.from({ length: info?.axes ?? 1 }, (_, n) => {
      return { axis: n + 1, ...this.machine.of(n + 1), switch: (switches >> n) % 2 === 1 };
    });
    const protocol = info && `${info.major}.${info.minor}`;
    this.board = { name: wire.name, protocol, can: info?.can ?? [], max_speed: info?.max ?? null, axes, settings, machine: null, form: () => this.machineForm() };
    if (this.axes.length !== axes.length) this.axes = axes.map(({ axis }) => new Watched(axis));
    this.sheet++;
  }

  /** The form of the machine, which the settings show. */
  machineForm() {
    return machineForm(this.machine, this.axes.length, () => {
      if (this.axes.some((axis) => axis.moving || axis.homing)) return "Not while a motor moves: it stays as it was.";
      const axes = this.board.axes.map((one) => ({ ...one, ...this.machine.of(one.axis) }));
      this.board = { ...this.board, axes };
      this.sheet++;
      this.publish();
      return null;
    });
  }

  watched(number) {
    const watched = this.axes.find((one) => one.axis === number);
    if (watched) return watched;
    throw new Declined({ what: `the board has no axis ${number}`, allowed: `1 to ${this.axes.length}` }, 400);
  }

  /** Looks at the axes that move. */
  async look() {
    let ended = false;
    for (const axis of this.axes.filter((one) => one.moving)) {
      // A stop is waited for: it goes first.
      if (this.jobs[0]?.urgent) return;
      ended = (await this.lookAt(axis)) || ended;
    }
    if (ended) await this.askWhy();
  }

  async lookAtAll() {
    for (const axis of this.axes) {
      if (this.jobs[0]?.urgent) return;
      await this.lookAt(axis);
    }
    await this.askWhy();
  }

  /** Whether it has come to rest since the last look. */
  async lookAt(axis) {
    // First whether it rests, then where: the other way round it might move on.
    const busy = await this.session.busy(axis.axis);
    axis.see(this.time(), await this.session.position(axis.axis));
    const ended = axis.moving && !busy;
    axis.moving = busy;
    axis.runs &&= busy;
    return ended;
  }

  /** Asks what has stopped axes, and what has gone wrong. */
  async askWhy() {
    const info = await this.session.why();
    if (!info) return;
    for (const axis of this.axes) axis.stop = axis.moving ? null : info.stops[axis.axis - 1];
    if (this.leased && !this.axes.some((axis) => axis.runs || axis.homing)) {
      await this.session.ask("L0");
      this.leased = false;
    }
  }

  // What the views hear.

  state() {
    const time = this.time();
    const lost = this.connected ? {} : { position: null, moving: false, state: "lost", stop: null };
    const { late = 0, refused = 0, errors = [] } = this.session?.info ?? {};
    const axes = this.axes.map((axis) => ({ ...axis.state(time), ...lost }));
    const control = { hand: 1, name: "this page", live: true };
    return { time, connected: this.connected, trouble: this.trouble, axes, late, refused, errors, control, sheet: this.sheet };
  }

  publish() {
    if (this.board) this.told({ type: "state", ...this.state() });
  }

  heard(said) {
    if (!said.question || this.asked) this.told({ type: "line", time: this.time(), ...said });
  }

  note(text) {
    this.told({ type: "note", time: this.time(), text });
  }

  unplan(axis) {
    this.told({ type: "unplanned", axis, time: this.time() });
  }

  /** Tells where an order will take an axis; nothing, if its ramps are too long to be walked. */
  plan(order, from, begin) {
    const { axis, endless, top_speed: top, start_speed: start, accel, decel, jerk } = order;
    const sign = Math.sign(order.steps);
    const far = endless ? Infinity : Math.abs(order.steps);
    // Of a long travel both ends are planned, and the level way between them is put in.
    const ramp = Math.max(0, top * top - start * start) / (2 * Math.min(accel, decel));
    const steps = Math.min(far, Math.ceil(8 * ramp + top));
    const numbers = this.planner.example();
    const values = { steps, start, top, accel, decel, ...(jerk && { jerk }) };
    for (const [name, value] of Object.entries(values)) numbers[NUMBERS.indexOf(name)] = value;
    const law = LAWS.indexOf(jerk ? "s-curve" : "trapezoid");
    const { curves, figures } = steps > 0 && steps <= WALKED ? this.planner.plan(law, numbers) : {};
    if (!curves || (steps < far && figures.peak < 0.99 * top)) return this.unplan(axis);
    const last = curves.time.length - 1;
    const stride = Math.max(1, Math.ceil(last / POINTS));
    const curve = { seconds: [], position: [], speed: [] };
    const put = (time, at, speed) => {
      curve.seconds.push(time);
      curve.position.push(from + sign * at);
      curve.speed.push(sign * speed);
    };
    const more = endless ? LONG * top : far - steps;
    for (let n = 0; ; n = Math.min(last, n + stride)) {
      const level = curves.position[n] > steps / 2 ? more : 0;
      // Behind its first pulse the axis is a step further.
      put(curves.time[n] + level / top, curves.position[n] + 1 + level, curves.speed[n]);
      // A run ends nowhere.
      if (n === last || (endless && level)) break;
    }
    this.told({ type: "plan", axis, begin, ...curve });
  }
}
