// Shared by the tests of the page: stepwrights that are started, and a browser that is watched.
//
// The arguments begin with STEPWRIGHT and CHROMIUM. Playwright is found through NODE_PATH.

import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname, join } from "node:path";
import { gzipSync } from "node:zlib";

const { chromium } = createRequire(import.meta.url)("playwright-core");
const [, , path, executablePath] = process.argv;

/** The command. */
export const stepwright = path;

/** The running programs: a test that fails leaves none behind. */
export const running = new Set();

/** Longer than anything here takes, even on a busy computer, in ms. */
const LIMIT = 60_000;

/** A program, the rest of its first line with this beginning, and all its lines so far. */
export function launch(begin, program, args, stdin = "ignore") {
  const child = spawn(program, args, { stdio: [stdin, "pipe", "inherit"] });
  running.add(child);
  child.on("exit", () => running.delete(child));
  return new Promise((tell, fail) => {
    let text = "";
    const lines = () => text.split("\n").slice(0, -1);
    child.stdout.on("data", (data) => {
      text += data;
      const line = lines().find((one) => one.startsWith(begin));
      if (line) tell({ child, said: line.slice(begin.length), lines });
    });
    child.on("exit", () => fail(new Error(`${args.join(" ")} ended: ${text}`)));
  });
}

/** The same for stepwright. */
export const start = (begin, ...args) => launch(begin, stepwright, args);

/** Kills a program. */
export const end = (child) => new Promise((ended) => (child.on("exit", ended), child.kill("SIGKILL")));

/** A page that is served, and its address. */
export const serve = (...args) =>
  start("page ", "serve", "--machine", "none", "--bind", "127.0.0.1:0", ...args);

/** Waits until `holds` returns a true value, and returns that. */
export async function until(what, holds) {
  const begin = Date.now();
  for (;;) {
    const held = await holds();
    if (held) return held;
    if (Date.now() - begin > LIMIT) throw new Error(`never: ${what}`);
    await new Promise((later) => setTimeout(later, 20));
  }
}

const KINDS = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".wasm": "application/wasm" };

/** A host that knows no API: the files of a folder, compressed as such hosts send them. */
export async function host(folder) {
  const server = createServer((request, answer) => {
    const name = new URL(request.url, "http://here").pathname.replace(/\/$/, "/index.html");
    try {
      const bytes = gzipSync(readFileSync(join(folder, name)));
      const kind = KINDS[extname(name)] ?? "application/octet-stream";
      answer.writeHead(200, { "Content-Type": kind, "Content-Encoding": "gzip" }).end(bytes);
    } catch {
      answer.writeHead(404, { "Content-Type": "text/html" }).end("<p>nothing here");
    }
  });
  await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
  const close = () => (server.close(), server.closeAllConnections());
  return { url: `http://127.0.0.1:${server.address().port}/`, close };
}

export const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });

/** Only tests with this in their names are run. */
const ONLY = process.env.STEPWRIGHT_PAGE_ONLY ?? "";

/** Runs tests one after another, each with `after(whether it failed)`; returns how many failed. */
export async function play(tests, after = () => {}) {
  let failed = 0;
  for (const [name, test] of Object.entries(tests).filter(([name]) => name.includes(ONLY))) {
    let broken = false;
    const begin = Date.now();
    try {
      await test();
      console.log(`passed: ${name}, in ${((Date.now() - begin) / 1000).toFixed(1)} s`);
    } catch (error) {
      broken = true;
      failed++;
      console.log(`FAILED: ${name}\n${error.stack}`);
      for (const context of browser.contexts()) await context.close();
    }
    await after(broken);
  }
  return failed;
}

/** A page that is watched for errors; `before(page)` prepares it. */
export async function watched(url, options, before = () => {}) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  await before(page);
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (said) => said.type() === "error" && faults.push(said.text()));
  await page.goto(url);
  return { context, page, faults };
}
