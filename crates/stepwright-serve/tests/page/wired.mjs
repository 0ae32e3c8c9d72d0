// The page without a server at a serial port: a stand-in for `navigator.serial` leads through this
// process to the pseudo-terminal of a board.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { constants, openSync, writeSync } from "node:fs";
import { ReadStream } from "node:tty";

import { end, start, stepwright, until } from "./common.mjs";
import { arrives, click, fill, jogs, kills, moves, open, shown, stops, travels, word } from "./steps.mjs";

/** In the page: a serial port whose bytes go through `serialWrite`, and come by `serialBytes`. */
function standIn() {
  class Port extends EventTarget {
    getInfo() {
      return { usbVendorId: 0x2341, usbProductId: 0x0043 };
    }

    async open({ baudRate }) {
      if (this.opened) throw new DOMException("The port is already open.", "InvalidStateError");
      if (!(await window.serialOpen(baudRate))) throw new DOMException("Failed to open serial port.", "NetworkError");
      this.opened = true;
      this.readable = new ReadableStream({ start: (to) => (this.to = to) });
      this.writable = new WritableStream({ write: (bytes) => window.serialWrite([...bytes]) });
    }

    async close() {
      if (!this.opened) throw new DOMException("The port is already closed.", "InvalidStateError");
      if (this.readable?.locked || this.writable?.locked) throw new TypeError("Cannot close a locked stream.");
      this.opened = false;
      this.readable = this.writable = null;
      await window.serialClose();
    }

    /** The device is gone, as in the browser: the streams have ended, the port is still open. */
    lose() {
      const { to } = this;
      this.readable = this.writable = null;
      to.error(new DOMException("The device has been lost.", "NetworkError"));
    }
  }
  const port = new Port();
  window.serialBytes = (bytes) => port.readable && port.to.enqueue(Uint8Array.from(bytes));
  window.serialLost = () => port.readable && port.lose();
  const serial = { requestPort: async () => port, getPorts: async () => [port] };
  Object.defineProperty(Navigator.prototype, "serial", { get: () => serial, configurable: true });
}

/** A board on a pseudo-terminal, and the page's link to it. */
class Bridge {
  /** `begin()` starts a board, and returns its process and the path of its terminal. */
  constructor(begin) {
    this.begin = begin;
  }

  /** Plugs a board in. */
  async plug() {
    const { child, said } = await this.begin();
    [this.board, this.path] = [child, said];
  }

  /** Unplugs it. */
  async pull(page) {
    await end(this.board);
    this.path = null;
    this.close();
    await page.evaluate(() => window.serialLost());
  }

  close() {
    // It closes the file as well.
    this.stream?.destroy();
    this.stream = null;
  }

  async prepare(page) {
    await page.addInitScript(standIn);
    await page.exposeFunction("serialOpen", (baud) => {
      assert.equal(baud, 115200);
      if (!this.path) return false;
      this.file = openSync(this.path, constants.O_RDWR | constants.O_NOCTTY);
      this.stream = new ReadStream(this.file);
      this.stream.on("error", () => {});
      this.stream.on("data", (bytes) => page.evaluate((bytes) => window.serialBytes(bytes), [...bytes]).catch(() => {}));
      return true;
    });
    await page.exposeFunction("serialWrite", (bytes) => {
      if (this.stream) writeSync(this.file, Uint8Array.from(bytes));
    });
    await page.exposeFunction("serialClose", () => this.close());
  }

  /** The board's answer to a program. The page must have left the board. */
  status() {
    const said = execFileSync(stepwright, ["status", "--port", this.path, "--format", "json"], {
      encoding: "utf8", env: { ...process.env, STEPWRIGHT_MACHINE: "none" },
    });
    return JSON.parse(said);
  }

  end() {
    this.close();
    this.board?.kill("SIGKILL");
  }
}

/** A page that has chosen a board on a serial port; `begin` as above. */
export async function wired(url, begin) {
  const bridge = new Bridge(begin);
  await bridge.plug();
  const opened = await open(url, {}, (page) => bridge.prepare(page));
  await opened.page.locator("#ways").selectOption("serial");
  await until("the board is met", () => opened.page.locator("body.wired").count());
  await until("it is the serial port", async () => (await opened.page.title()).includes("2341:0043"));
  // Except the question whether there is a server.
  const faults = () => opened.faults.filter((fault) => !fault.includes("404"));
  return { bridge, ...opened, faults };
}

/** Leaves the board, and asks for its status. */
export async function left({ page, bridge }) {
  await page.locator("#ways").selectOption("virtual");
  await until("the virtual board is met", async () => (await page.title()).includes("virtual"));
  return bridge.status();
}

/** A port that vanishes during a run, and comes back. */
export async function vanishes({ page, card, bridge }) {
  await click(card, "run-ahead");
  await moves(card);
  await bridge.pull(page);
  await until("no board", async () => (await word(card)) === "no board");
  assert.equal(await shown(card), "?");
  await page.locator("#notices").getByText("it is met again").first().waitFor();
  await bridge.plug();
  await arrives(card, 0);
  await fill(card, "target", 60);
  await click(card, "to");
  await arrives(card, 60);
}

/** The virtual board on a pseudo-terminal; only the page knows its position. */
async function board(url) {
  const driven = await wired(url, () => start("pty ", "board", "--pty"));
  return { ...driven, at: async () => Number(await shown(driven.card)) || 0 };
}

/** Ends a test, and returns the board's answer about axis 1. */
async function ended(driven) {
  const { axes } = await left(driven);
  await driven.context.close();
  driven.bridge.end();
  return [axes[0].position, axes[0].stop];
}

export const tests = {
  async "on a serial port it travels, and jogs"(url) {
    const driven = await board(url);
    await travels(driven);
    await jogs(driven);
    const at = Number(await shown(driven.card));
    assert.deepEqual(driven.faults(), []);
    assert.equal((await ended(driven))[0], at);
  },

  async "a command for a board on a serial port has its port left open"(url) {
    const driven = await board(url);
    const { page } = driven;
    for (const [view, button, said] of [
      ["plan", "#copy-command", "stepwright move 1000 --port PORT --top-speed 1000 --accel 2000 --start-speed 0"],
      ["paths", "#paths-copy", "stepwright cycle examples/cycles/drawing.toml --port PORT"],
    ]) {
      await page.click(`nav a[href="#${view}"]`);
      await until("it is there", () => page.locator(view === "plan" ? "#laws td:nth-child(2)" : "#paths-legs tbody tr").count());
      await page.locator(button).click();
      assert.equal(await page.locator(`#${view} pre`).innerText(), said);
    }
    assert.equal((await ended(driven))[0], 0);
  },

  async "on a serial port it is stopped"(url) {
    const driven = await board(url);
    await stops(driven);
    const at = Number(await shown(driven.card));
    assert.deepEqual(await ended(driven), [at, "stop"]);
  },

  async "on a serial port it kills"(url) {
    const driven = await board(url);
    await kills(driven);
    await click(driven.card, "run-ahead");
    await moves(driven.card);
    await driven.page.keyboard.press("Shift+K");
    await until("? is shown", async () => (await shown(driven.card)) === "?");
    assert.deepEqual(await ended(driven), [null, "kill"]);
  },

  async "a port that vanishes is met again, and nothing moves by itself"(url) {
    const driven = await board(url);
    await vanishes(driven);
    assert.equal((await ended(driven))[0], 60);
  },

  async "a page that is closed runs nothing"(url) {
    const { card, bridge, context } = await board(url);
    await click(card, "run-ahead");
    await moves(card);
    await context.close();
    bridge.close();
    // The board has heard nothing for its lease of 2.5 s, and brakes.
    await new Promise((later) => setTimeout(later, 4000));
    assert.equal(bridge.status().axes[0].stop, "timeout");
    bridge.end();
  },
};
