// What the tests of the page share: stepwrights that are started, and a browser that is watched.
//
// Their arguments begin with STEPWRIGHT and CHROMIUM. Playwright is found through NODE_PATH.

import { spawn } from "node:child_process";
import { createRequire } from "node:module";

const { chromium } = createRequire(import.meta.url)("playwright-core");
const [, , path, executablePath] = process.argv;

/** The command. */
export const stepwright = path;

/** Those that run: a test that fails leaves none behind. */
export const running = new Set();

/** Longer than anything here takes, even on a loaded machine, in ms. */
const LIMIT = 60_000;

/** A stepwright, and its first line that begins so, without that beginning. */
export function start(begin, ...args) {
  const child = spawn(stepwright, args, { stdio: ["ignore", "pipe", "inherit"] });
  running.add(child);
  child.on("exit", () => running.delete(child));
  return new Promise((tell, fail) => {
    let text = "";
    child.stdout.on("data", (data) => {
      text += data;
      const line = text.split("\n").find((one, i, all) => i < all.length - 1 && one.startsWith(begin));
      if (line) tell({ child, said: line.slice(begin.length) });
    });
    child.on("exit", () => fail(new Error(`${args.join(" ")} ended: ${text}`)));
  });
}

/** A page that is served, and its address. */
export const serve = (...args) =>
  start("page ", "serve", "--machine", "none", "--bind", "127.0.0.1:0", ...args);

/** Waits until it holds; what held. */
export async function until(what, holds) {
  const begin = Date.now();
  for (;;) {
    const held = await holds();
    if (held) return held;
    if (Date.now() - begin > LIMIT) throw new Error(`never: ${what}`);
    await new Promise((later) => setTimeout(later, 20));
  }
}

export const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });

/** A page that is watched for errors. */
export async function watched(url, options) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (said) => said.type() === "error" && faults.push(said.text()));
  await page.goto(url);
  return { context, page, faults };
}
