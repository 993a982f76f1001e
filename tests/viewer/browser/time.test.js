// Sequences in time, as a user plays them.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { isDifferent, isSame, pagesIn, reload, section, set, state } from "./shared.js";
import { drag, measured, pixels, refined } from "./viewer.js";

const [SIDE, STEPS] = [16, 5];

/** A block that moves along x and brightens. */
const block = (step) => Buffer.from(Array.from({ length: SIDE ** 3 }, (_, n) => {
  const [x, y, z] = [n % SIDE, Math.floor(n / SIDE) % SIDE, Math.floor(n / SIDE / SIDE)];
  return x >= 2 * step + 1 && x < 2 * step + 6 && y >= 5 && y < 11 && z >= 5 && z < 11 ? 80 + 40 * step : 0;
}));

const steps = Object.fromEntries(Array.from({ length: STEPS }, (_, step) => [`step${step}_16x16x16_uint8.raw`, block(step)]));
const on = pagesIn(steps, "step%d_16x16x16_uint8.raw", "--azimuth", "0", "--elevation", "20");

const frame = async (page) => (await state(page)).look.frame;
const isAt = (page, step) => page.waitForFunction((to) => globalThis.layersplat.state().look.frame === to, step);
/** Collects the steps of a second or two, until all were shown. */
const seen = async (page) => {
  const steps = new Set();
  while (steps.size < STEPS) {
    steps.add(await frame(page));
    await page.waitForTimeout(20);
  }
};

on("the slider and keys choose a step, which is refined, undone and kept in the address", async (page, first) => {
  assert.equal(await page.locator("#time-shown").textContent(), "1 of 5");
  await set(page, "#time-step", 4);
  const last = await refined(page);
  isDifferent(last, first, "the last step");
  assert.ok(measured(last).x > measured(first).x + 0.2, "the block has moved");
  assert.equal(await page.locator("#time-shown").textContent(), "5 of 5");
  await page.locator("#picture").focus();
  await page.keyboard.press("]");
  await isAt(page, 0);
  isSame(await refined(page), first, "after the last comes the first");
  await page.keyboard.press("[");
  await isAt(page, 4);
  isSame(await refined(page), last, "and before it the last");
  await page.keyboard.press("Control+z");
  await isAt(page, 0);
  isSame(await refined(page), first, "undone");
  // Keys of the slider itself.
  await page.locator("#time-step").focus();
  await page.keyboard.press("ArrowRight");
  await isAt(page, 1);
  await refined(page);
  await page.waitForFunction(() => location.hash.length > 1);
  await reload(page);
  await page.waitForFunction(() => globalThis.layersplat?.state()?.look.frame === 1);
  await refined(page);
});

on("time runs with the button and Space, in a loop, and a hand turns meanwhile", async (page, first) => {
  await set(page, "#time-rate", 20);
  await page.locator("#time-play").click();
  assert.equal(await page.locator("#time-play").getAttribute("aria-pressed"), "true");
  await seen(page);
  await page.screenshot({ path: process.env.SCREENSHOTS ? join(process.env.SCREENSHOTS, "time.png") : undefined });
  const before = (await state(page)).camera.azimuth;
  await drag(page, 120, 0);
  assert.notEqual((await state(page)).camera.azimuth, before);
  await seen(page);
  // A button has the key if it is focused, else the page.
  await page.locator("#picture").focus();
  await page.keyboard.press(" ");
  assert.equal(await page.locator("#time-play").textContent(), "Play");
  const rested = await refined(page);
  const step = await frame(page);
  await page.waitForTimeout(300);
  assert.equal(await frame(page), step, "time stands");
  isSame(await pixels(page), rested, "the picture, too");
  isDifferent(rested, first, "turned");
  await page.keyboard.press(" ");
  await seen(page);
  await page.locator("#time-play").focus();
  await page.keyboard.press(" ");
  assert.equal(await page.locator("#time-play").getAttribute("aria-pressed"), "false");
  await refined(page);
});

on("steps come at the chosen rate", async (page) => {
  await set(page, "#time-rate", 4);
  await page.locator("#time-play").click();
  const start = await frame(page);
  const began = Date.now();
  await page.waitForFunction((step) => globalThis.layersplat.state().look.frame === (step + 3) % 5, start);
  const took = Date.now() - began;
  // Three steps of 250 ms; a busy machine is slower, never faster.
  assert.ok(took > 600, String(took));
  await page.locator("#time-play").click();
  await refined(page);
});

on("commands and films name the step", async (page) => {
  await set(page, "#time-step", 3);
  await refined(page);
  await page.locator("#picture").focus();
  const download = page.waitForEvent("download");
  await page.keyboard.press("c");
  await download;
  const line = await page.locator("#command").inputValue();
  assert.ok(line.startsWith("layersplat render step%d_16x16x16_uint8.raw --frame 3 "), line);
  await section(page, "Film");
  await page.locator("#film-add").click();
  await set(page, "#time-step", 1);
  const second = await refined(page);
  await page.locator("#film-add").click();
  const shows = page.locator("#film-keys").getByRole("button", { name: "Show key camera" });
  assert.deepEqual(await shows.allTextContents(), ["Show 4", "Show 2"]);
  await shows.nth(0).click();
  await isAt(page, 3);
  isDifferent(await refined(page), second, "the first key's step");
  await shows.nth(1).click();
  await isAt(page, 1);
  isSame(await refined(page), second, "the second key's step");
  for (const [id, value] of [["#film-width", 40], ["#film-height", 30], ["#film-rate", 4]]) await set(page, id, value);
  const film = page.waitForEvent("download");
  await page.locator("#film-make").click();
  assert.equal((await film).suggestedFilename(), "layersplat.gif");
  const files = [];
  page.on("download", async (file) => {
    if (file.suggestedFilename() === "layersplat-keys.json") files.push(await file.path());
  });
  await page.locator("#film-files").click();
  while (files.length < 1) await page.waitForTimeout(50);
  assert.deepEqual(JSON.parse(await readFile(files[0], "utf8")).map((key) => key.frame), [3, 1]);
});

on("axe finds nothing, the controls have names, and all are on a narrow page", async (page) => {
  await page.evaluate(await readFile(createRequire(import.meta.url).resolve("axe-core"), "utf8"));
  const { violations } = await page.evaluate(() => globalThis.axe.run("#time"));
  assert.deepEqual(violations.map(({ id }) => id), []);
  const names = await page.locator("#time").evaluate((bar) => [bar.ariaLabel, ...[...bar.querySelectorAll("input")].map((input) => input.ariaLabel ?? input.labels[0]?.textContent.trim())]);
  assert.deepEqual(names, ["Time", "Step", "Steps/s"]);
  await page.setViewportSize({ width: 360, height: 640 });
  await page.locator("#fold").click();
  const box = await page.locator("#time").boundingBox();
  assert.ok((await page.locator("#time-step").boundingBox()).width > 150);
  assert.ok(box.x >= 0 && box.x + box.width <= 360 && box.y + box.height <= 640, JSON.stringify(box));
  await page.screenshot({ path: process.env.SCREENSHOTS ? join(process.env.SCREENSHOTS, "time-narrow.png") : undefined });
});
