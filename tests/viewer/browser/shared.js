// What the tests of the page share.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { difference, launch, open, pixels, serve } from "./viewer.js";

/** Mean difference of pictures that a user would call different, in 8-bit steps. */
export const DIFFERENT = 0.8;
/** Of pictures of the same view, after rounding of angles. */
export const SAME = 0.02;

/** Makes tests with pages of their own, which must not report errors or ask others for anything. `where`: the browser and the server's address. */
export const pagesOf = (where) => (name, body, context) => test(name, async () => {
  const page = await open(...where(), context);
  try {
    await body(page, await pixels(page));
    assert.deepEqual([page.errors, page.foreign], [[], []]);
  } finally {
    await page.context().close();
  }
});

/** Serves a volume for the tests of a file. */
export function pages(...options) {
  let server;
  let browser;
  before(async () => {
    server = await serve(...options);
    browser = await launch();
  });
  after(async () => {
    await browser.close();
    await server.end();
  });
  return pagesOf(() => [browser, server.url]);
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

/** The page's state. */
export const state = (page) => page.evaluate(() => globalThis.layersplat.state());
