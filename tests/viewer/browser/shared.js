// What the tests of the page share.

import assert from "node:assert/strict";
import { mkdir, mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { difference, launch, open, pixels, serveIn } from "./viewer.js";

/** Mean difference of pictures that a user would call different, in 8-bit steps. */
export const DIFFERENT = 0.8;
/** Of pictures of the same view, after rounding of angles. */
export const SAME = 0.02;

/** The browser of all tests of a file, once one of them wants it. A promise: what comes before the tests begins at once for all servers. */
let launched;

/** Serves a volume for the tests of a file. */
export const pages = (...options) => pagesIn({}, ...options);

/** Serves the volumes of a folder, whose `files` have these bytes by their names, for the tests of a file. Returns what makes tests with pages of
 * their own, which must not report errors or ask others for anything, and which knows the browser and the server. */
export function pagesIn(files, ...options) {
  let folder;
  let server;
  let browser;
  before(async () => {
    folder = await mkdtemp(join(tmpdir(), "layersplat-test-"));
    await mkdir(join(folder, "temporary"));
    await Promise.all(Object.entries(files).map(([name, bytes]) => writeFile(join(folder, name), bytes)));
    server = await serveIn(folder, ...options);
    launched ??= launch();
    browser = await launched;
  });
  after(async () => {
    await browser.close();
    await server.end();
    // Programs that are still being built leave files here.
    await rm(folder, { recursive: true, force: true, maxRetries: 5 });
  });
  const on = (name, body, context) => test(name, async () => {
    const page = await open(browser, server.url, context);
    try {
      await body(page, await pixels(page));
      assert.deepEqual([page.errors, page.foreign], [[], []]);
    } finally {
      await page.context().close();
    }
  });
  return Object.assign(on, { browser: () => browser, server: () => server });
}

export const isDifferent = (a, b, what) => assert.ok(difference(a, b) > DIFFERENT, `${what}: ${difference(a, b)}`);
export const isSame = (a, b, what) => assert.ok(difference(a, b) <= SAME, `${what}: ${difference(a, b)}`);
export const section = (page, name) => page.locator("summary", { hasText: name }).click();

/** Does something that the server answers before the picture changes. */
export async function answered(page, action) {
  const before = await page.evaluate(() => globalThis.layersplat.requested());
  await action();
  await page.waitForFunction((id) => globalThis.layersplat.requested() > id, before);
}

/** Sets a slider or a number, as a hand does. */
export const set = (page, id, value) => page.locator(id).evaluate((field, to) => {
  field.value = String(to);
  field.dispatchEvent(new Event("input", { bubbles: true }));
  field.dispatchEvent(new Event("change", { bubbles: true }));
}, value);

/** Reloads the page. Its address gets its state 300 ms after the last change, so a timer of the page that is longer and begins later ends after it. */
export async function reload(page) {
  await page.evaluate(() => new Promise((kept) => setTimeout(kept, 500)));
  await page.reload();
}

/** The page's state. */
export const state = (page) => page.evaluate(() => globalThis.layersplat.state());
