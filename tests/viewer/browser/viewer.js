// A server, a browser, and what a user sees: the pixels of the picture.

import { chromium } from "playwright-core";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { tmpdir } from "node:os";

/** Milliseconds; only a hang reaches it. */
const PATIENCE = 180_000;
const BINARY = new URL(`../../../${process.env.LAYERSPLAT_BINARY ?? "target/debug/layersplat"}`, import.meta.url).pathname;
const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";

export const serve = (...options) => started(options, { cwd: tmpdir() });

/** In a folder, whose subfolder `temporary` is for temporary files. */
export const serveIn = (folder, ...options) => started(options, { cwd: folder, env: { ...process.env, TMPDIR: `${folder}/temporary` } });

async function started(options, where) {
  const server = spawn(BINARY, ["view", "--no-browser", ...options], { stdio: ["ignore", "pipe", "ignore"], ...where });
  const [line] = await once(server.stdout, "data");
  return { url: line.toString().trim(), end: () => { server.kill("SIGINT"); return once(server, "exit"); }, process: server };
}

export const launch = () => chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox"] });

/** Opens a page and waits for its refined picture. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 900, height: 600 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (line) => { if (line.type() === "error") errors.push(line.text()); });
  const foreign = [];
  page.on("request", (request) => { if (new URL(request.url()).host !== new URL(url).host) foreign.push(request.url()); });
  await page.goto(url);
  await refined(page);
  return Object.assign(page, { errors, foreign });
}

/** Waits until the newest view is refined, and returns its pixels. */
export async function refined(page) {
  await page.waitForFunction(() => {
    const viewer = globalThis.layersplat;
    return viewer && viewer.shown.step === "refined" && viewer.shown.id === viewer.requested();
  }, null, { timeout: PATIENCE });
  return pixels(page);
}

/** The picture, scaled to 96 × 64. */
export async function pixels(page) {
  const data = await page.evaluate(() => {
    const [width, height] = [96, 64];
    const canvas = new OffscreenCanvas(width, height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(document.getElementById("picture"), 0, 0, width, height);
    return [...context.getImageData(0, 0, width, height).data];
  });
  return { width: 96, height: 64, data };
}

/** Mean difference of two pictures in 8-bit steps. */
export function difference(a, b) {
  return a.data.reduce((sum, value, n) => sum + Math.abs(value - b.data[n]), 0) / a.data.length;
}

/** Mean of a channel, and the centre of the bright part: −1 … 1 to the right and upwards, and its width. */
export function measured({ width, height, data }) {
  let [weight, x, y, xx] = [0, 0, 0, 0];
  const mean = [0, 0, 0, 0];
  for (let n = 0; n < width * height; n += 1) {
    const pixel = data.slice(4 * n, 4 * n + 4);
    pixel.forEach((value, channel) => { mean[channel] += value / (width * height); });
    const bright = pixel[0] + pixel[1] + pixel[2];
    const [px, py] = [((n % width) + 0.5) / width * 2 - 1, 1 - (Math.floor(n / width) + 0.5) / height * 2];
    weight += bright;
    x += bright * px;
    y += bright * py;
    xx += bright * px * px;
  }
  x /= weight;
  return { mean, x, y: y / weight, spread: Math.sqrt(xx / weight - x * x) };
}

/** Drags over the picture by pixels. */
export async function drag(page, dx, dy, { from = [280, 300], button = "left", key = null } = {}) {
  if (key) await page.keyboard.down(key);
  await page.mouse.move(...from);
  await page.mouse.down({ button });
  for (let n = 1; n <= 6; n += 1) await page.mouse.move(from[0] + (dx * n) / 6, from[1] + (dy * n) / 6);
  await page.mouse.up({ button });
  if (key) await page.keyboard.up(key);
}
