// The page without a server at a serial port: a stand-in for `navigator.serial` leads through this
// process to the pseudo-terminal of a board.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { constants, openSync, writeSync } from "node:fs";
import { ReadStream } from "node:tty";

import { start, stepwright } from "./common.mjs";

/** In the page: a serial port whose bytes go through `serialWrite`, and come by `serialBytes`. */
function standIn() {
  class Port extends EventTarget {
    getInfo() {
      return { usbVendorId: 0x2341, usbProductId: 0x0043 };
    }

    async open({ baudRate }) {
      if (this.readable) throw new DOMException("The port is already open.", "InvalidStateError");
      if (!(await window.serialOpen(baudRate))) throw new DOMException("Failed to open serial port.", "NetworkError");
      this.readable = new ReadableStream({ start: (to) => (this.to = to) });
      this.writable = new WritableStream({ write: (bytes) => window.serialWrite([...bytes]) });
    }

    async close() {
      if (this.readable?.locked || this.writable?.locked) throw new TypeError("Cannot close a locked stream.");
      this.readable = this.writable = null;
      await window.serialClose();
    }

    /** The device is gone, as the browser tells it. */
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

/** A board on a pseudo-terminal, and the page's way to it. */
class Bridge {
  /** Plugs a board in. */
  async plug() {
    const { child, said } = await start("pty ", "board", "--pty");
    [this.board, this.path] = [child, said];
  }

  /** Pulls it out. */
  async pull(page) {
    const gone = new Promise((ended) => this.board.on("exit", ended));
    this.board.kill("SIGKILL");
    await gone;
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

  /** What the board says to a program. The page must have left it. */
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

/** The tests, by the helpers of alone.mjs. */
export function tests({ open, fill, click, shown, word, moves, rests, until }) {
  /** A page that has chosen a board on a serial port. */
  async function wired(url) {
    const bridge = new Bridge();
    await bridge.plug();
    const opened = await open(url, {}, (page) => bridge.prepare(page));
    await opened.page.locator("#ways").selectOption("serial");
    await until("the board is met", () => opened.page.locator("body.wired").count());
    await until("it is the serial port", async () => (await opened.page.title()).includes("2341:0043"));
    return { bridge, ...opened };
  }
  /** Leaves the board, and asks it where it is. */
  async function left({ page, bridge }) {
    await page.locator("#ways").selectOption("virtual");
    await until("the virtual board is met", async () => (await page.title()).includes("virtual"));
    return bridge.status();
  }

  return {
    async "on a serial port it travels, jogs, and is stopped"(url) {
      const { page, card, bridge, context, faults } = await wired(url);
      await fill(card, "speed", 2000);
      await fill(card, "accel", 20000);
      await fill(card, "target", 700);
      await click(card, "to");
      await until("700 is shown", async () => (await shown(card)) === "700");
      await fill(card, "target", -200);
      await click(card, "by");
      await until("500 is shown", async () => (await shown(card)) === "500");
      await card.locator("[name=ahead]").hover();
      await page.mouse.down();
      await until("it has gone far", async () => Number(await shown(card)) > 800);
      await page.mouse.up();
      await rests(card);
      await click(card, "run-back");
      await moves(card);
      await page.keyboard.press("Space");
      const at = Number(await rests(card));
      await card.getByText("Stopped by a soft stop").waitFor();
      const { axes } = await left({ page, bridge });
      assert.deepEqual([axes[0].position, axes[0].stop], [at, "brake"]);
      assert.deepEqual(faults(), []);
      await context.close();
      bridge.end();
    },

    async "on a serial port it kills"(url) {
      const { page, card, bridge, context } = await wired(url);
      await click(card, "run-ahead");
      await moves(card);
      await page.locator("#kill").hover();
      await page.mouse.down();
      await until("? is shown", async () => (await shown(card)) === "?");
      await page.mouse.up();
      const { axes } = await left({ page, bridge });
      assert.deepEqual([axes[0].position, axes[0].stop], [null, "kill"]);
      await context.close();
      bridge.end();
    },

    async "a port that vanishes is met again, and nothing moves by itself"(url) {
      const { page, card, bridge, context } = await wired(url);
      await click(card, "run-ahead");
      await moves(card);
      await bridge.pull(page);
      await until("no board", async () => (await word(card)) === "no board");
      assert.equal(await shown(card), "?");
      await page.locator("#notices").getByText("it is met again").first().waitFor();
      await bridge.plug();
      await until("0 is shown", async () => (await shown(card)) === "0");
      assert.equal(await word(card), "at rest");
      await fill(card, "target", 60);
      await click(card, "to");
      await until("60 is shown", async () => (await shown(card)) === "60");
      assert.equal((await left({ page, bridge })).axes[0].position, 60);
      await context.close();
      bridge.end();
    },

    async "a page that is closed runs nothing"(url) {
      const { card, bridge, context } = await wired(url);
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
}
