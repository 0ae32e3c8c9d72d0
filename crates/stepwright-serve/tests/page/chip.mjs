// The page with a simulated Uno, which runs its binary at the pace of a real one: over a WebSocket
// through `stepwright serve`, and over a serial port of the browser. The position on the page is
// compared with the edges of the chip's pins.
//
//   node chip.mjs STEPWRIGHT CHROMIUM STATIC SIM
//
// STATIC is the folder of the page for any host, SIM the simulator. On a slow computer the chip's time
// slows down: only the chip's seconds count here. Ends with 0 if all tests pass.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { browser, end, host, launch, play, running, serve, stepwright, until } from "./common.mjs";
import { arrives, click, fill, homes, jogs, kills, moves, open, rests, sets, shown, stops, travels, word } from "./steps.mjs";
import { left, vanishes, wired } from "./wired.mjs";

const [files, sim] = process.argv.slice(4);

const AXES = 3;

/** Simulated Unos, one after another, behind a terminal of one name. */
class Chip {
  constructor() {
    this.place = mkdtempSync(join(tmpdir(), "stepwright-chip-"));
    this.path = join(this.place, "port");
  }

  /** Switches a new Uno on. Axis 1 has a limit switch. */
  begin = async () => {
    const args = ["uno", "--switch", "1:-300", "--pty-link", this.path];
    const { child, lines } = await launch("pty ", sim, args, "pipe");
    Object.assign(this, { child, lines });
    return { child, said: this.path };
  };

  /** The chip's time in s, and the position of the first shaft, by the edges of its pins alone. */
  async look() {
    const heard = this.lines().length;
    this.act("where");
    await until("the simulator says where", () => this.lines().length >= heard + 1 + AXES);
    const said = this.lines().slice(heard, heard + 2).join("\n");
    const [, time, place] = /^cycles \d+, ([\d.]+) s\naxis 1: \d+ steps, from 0 to (-?\d+)$/.exec(said);
    return [Number(time), Number(place)];
  }

  at = async () => (await this.look())[1];

  /** The speed in steps/s of the chip's own time, over a fifth of a second. */
  speed = async () => {
    const [begun, from] = await this.look();
    for (;;) {
      const [time, place] = await this.look();
      if (time > begun + 0.2) return (place - from) / (time - begun);
    }
  };

  /** Changes the machine: see `cargo xtask sim`. */
  act(line) {
    this.child.stdin.write(`${line}\n`);
  }

  async end() {
    await end(this.child);
    rmSync(this.place, { recursive: true });
  }
}

/** The board's answer to a program. */
const says = (...args) =>
  execFileSync(stepwright, args, { encoding: "utf8", env: { ...process.env, STEPWRIGHT_MACHINE: "none" } });

/** The page through a server. */
async function served() {
  const chip = new Chip();
  await chip.begin();
  const { child, said: url } = await serve("--port", chip.path);
  const opened = await open(url);
  await opened.page.locator("#release").waitFor();
  const pull = () => end(chip.child);
  const left = async () => {
    await end(child);
    return JSON.parse(says("status", "--port", chip.path, "--format", "json"));
  };
  const leave = async () => {
    await opened.context.close();
    child.kill("SIGKILL");
    await chip.end();
  };
  return { chip, ...opened, at: chip.at, speed: chip.speed, bridge: { pull, plug: chip.begin }, left, leave };
}

/** The page at a port of the browser. */
async function alone(url) {
  const chip = new Chip();
  const opened = await wired(url, chip.begin);
  const leave = async () => {
    await opened.context.close();
    opened.bridge.close();
    await chip.end();
  };
  return { chip, ...opened, at: chip.at, speed: chip.speed, left: () => left(opened), leave };
}

/** The tests by one of these ways: `left()` leaves the board, and asks for its status. */
const by = (way, meet) => ({
  async [`${way} it travels, jogs and is stopped`]() {
    const driven = await meet();
    for (const act of [travels, jogs, stops]) await act(driven);
    const place = Number(await shown(driven.card));
    assert.equal(await driven.at(), place);
    const { axes } = await driven.left();
    assert.deepEqual([axes[0].position, axes[0].stop], [place, "stop"]);
    await driven.leave();
  },

  async [`${way} it is killed, and its pins stand still`]() {
    const driven = await meet();
    await kills(driven);
    await click(driven.card, "run-ahead");
    await moves(driven.card);
    await driven.page.keyboard.press("Shift+K");
    await until("? is shown", async () => (await shown(driven.card)) === "?");
    const stood = await driven.at();
    const { axes } = await driven.left();
    assert.deepEqual([axes[0].position, axes[0].stop], [null, "kill"]);
    assert.equal(await driven.at(), stood);
    await driven.leave();
  },

  async [`${way} its settings hold, and it homes`]() {
    const driven = await meet();
    await sets(driven);
    const place = await homes(driven);
    // 50 steps from the switch, which closes at -300 of the shaft, and is sampled every 128 µs.
    assert.ok(Math.abs(place + 250) <= 2, `${place}`);
    await driven.left();
    assert.match(says("settings", "get", "--port", driven.chip.path, "pulse-us"), /^7\b/);
    await driven.leave();
  },

  async [`${way} it vanishes, is met again, and nothing moves by itself`]() {
    const driven = await meet();
    await vanishes(driven);
    assert.equal(await driven.at(), 60);
    // Its reset button is pressed during a run: it stops, at an unknown position.
    await click(driven.card, "run-ahead");
    await moves(driven.card);
    driven.chip.act("reset");
    await until("it is uncertain", async () => (await word(driven.card)) === "position uncertain");
    assert.equal(await shown(driven.card), "?");
    const stood = await driven.at();
    await click(driven.card, "zero");
    await until("0 is shown", async () => (await shown(driven.card)) === "0");
    await fill(driven.card, "target", 30);
    await click(driven.card, "to");
    await arrives(driven.card, 30);
    assert.equal(await driven.at(), stood + 30);
    await driven.leave();
  },
});

let failed = 0;
const { url, close } = await host(files);
try {
  const sockets = by("over a WebSocket", served);
  const serial = by("over a serial port of the browser", () => alone(url));
  failed = await play({ ...sockets, ...serial });
} finally {
  await browser.close();
  close();
  for (const child of running) child.kill("SIGKILL");
}
process.exitCode = failed ? 1 : 0;
