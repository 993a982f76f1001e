// Films along key cameras, as a user makes them.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { DIFFERENT, pages, section, set } from "./shared.js";
import { difference, drag, pixels, refined } from "./viewer.js";

const onPage = pages("builtin:hydrogen@48");
const on = (name, body) => onPage(name, async (page) => {
  await section(page, "Film");
  await body(page);
});

const times = (page) => page.locator("#film-keys input").evaluateAll((fields) => fields.map((field) => Number(field.value)));
const key = (page, n, name) => page.locator("#film-keys li").nth(n).getByRole("button", { name });

on("key cameras are recorded, shown, moved, timed and deleted", async (page) => {
  assert.ok(await page.locator("#film-make").isDisabled());
  const first = await pixels(page);
  await page.locator("#film-add").click();
  await drag(page, 120, 0);
  const second = await refined(page);
  await page.locator("#picture").focus();
  await page.keyboard.press("k");
  assert.deepEqual(await times(page), [0, 2]);
  assert.ok(await page.locator("#film-make").isEnabled());
  const shows = async (n) => {
    const before = await page.evaluate(() => globalThis.layersplat.requested());
    await key(page, n, "Show key camera").click();
    await page.waitForFunction((id) => globalThis.layersplat.requested() > id, before);
    return refined(page);
  };
  assert.ok(difference(await shows(0), first) < DIFFERENT && difference(await shows(1), second) < DIFFERENT);
  // Cameras change places, times do not.
  await key(page, 0, "later").click();
  assert.deepEqual(await times(page), [0, 2]);
  assert.ok(difference(await shows(0), second) < DIFFERENT);
  // A time moves its camera behind the other one.
  await page.locator("#film-keys input").first().fill("5");
  await page.locator("#film-keys input").first().press("Tab");
  assert.deepEqual(await times(page), [2, 5]);
  assert.ok(difference(await shows(1), second) < DIFFERENT);
  await key(page, 0, "Delete").click();
  assert.deepEqual(await times(page), [5]);
});

on("a film is drawn with progress, while the page turns, and saved with its command", async (page) => {
  await page.locator("#film-add").click();
  await drag(page, 120, 30);
  await refined(page);
  await page.locator("#film-add").click();
  for (const [id, value] of [["#film-width", 96], ["#film-height", 64], ["#film-rate", 10]]) await set(page, id, value);
  const download = page.waitForEvent("download");
  await page.locator("#film-make").click();
  await page.waitForFunction(() => document.getElementById("film-state").textContent.startsWith("Picture"));
  const before = await pixels(page);
  await drag(page, -90, 0);
  assert.ok(difference(await refined(page), before) > DIFFERENT, "the page turns meanwhile");
  const film = await download;
  assert.equal(film.suggestedFilename(), "layersplat.gif");
  const bytes = await readFile(await film.path());
  assert.equal(bytes.subarray(0, 6).toString(), "GIF89a");
  // Logical size of the pictures, and one graphic control extension for each of them.
  assert.deepEqual([bytes.readUInt16LE(6), bytes.readUInt16LE(8)], [96, 64]);
  assert.ok((await page.locator("#film-state").textContent()).includes("21 pictures"));
  const line = await page.locator("#film-command").inputValue();
  assert.ok(line.startsWith("layersplat rotate builtin:hydrogen@48") && line.includes("--keys layersplat-keys.json"), line);
  const files = [];
  page.on("download", (file) => files.push(file.suggestedFilename()));
  await page.locator("#film-files").click();
  while (files.length < 2) await page.waitForTimeout(50);
  assert.deepEqual(files.sort(), ["layersplat-keys.json", "layersplat.json"]);
});

on("a film can be given up, and one that cannot be made says why", async (page) => {
  await page.locator("#film-add").click();
  await drag(page, 60, 0);
  await page.locator("#film-add").click();
  for (const [id, value] of [["#film-width", 800], ["#film-height", 600], ["#film-samples", 4], ["#film-rate", 50]]) await set(page, id, value);
  await page.locator("#film-make").click();
  await page.waitForFunction(() => document.getElementById("film-state").textContent.startsWith("Picture"));
  await page.locator("#film-cancel").click();
  await page.waitForFunction(() => document.getElementById("film-state").textContent.includes("given up"));
  assert.ok(await page.locator("#film-make").isEnabled() && await page.locator("#film-cancel").isHidden());
  await set(page, "#film-rate", 120);
  await page.locator("#film-make").click();
  await page.waitForFunction(() => document.getElementById("problem").textContent.includes("50 frames per second"));
  assert.ok(await page.locator("#film-make").isEnabled());
});
