// Slices beside the picture, as a user uses them.

import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { readFile } from "node:fs/promises";
import { describe } from "node:test";
import { pages, reload } from "./shared.js";
import { measured, refined } from "./viewer.js";

/** A test with a page of its own, whose slices are shown. */
const onPage = pages("builtin:hydrogen@48");
const on = (name, body, options) => onPage(name, async (page) => {
  await page.keyboard.press("v");
  await refined(page);
  await body(page, await slices(page));
}, options);

/** Waits until the newest slices are shown, and returns their pixels without crosshair, scaled to 48 × 48 each. */
async function slices(page) {
  await page.waitForFunction(() => {
    const slices = globalThis.layersplat.slices();
    return slices.requested > 0 && slices.shown === slices.requested && !slices.sent.isMoving;
  });
  return page.evaluate(() => {
    const { bitmap } = globalThis.layersplat.slices();
    return [0, 1, 2].map((n) => {
      const [width, height] = [48, 48];
      const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
      context.drawImage(bitmap, 0, (n * bitmap.height) / 3, bitmap.width, bitmap.height / 3, 0, 0, width, height);
      return { width, height, data: [...context.getImageData(0, 0, width, height).data] };
    });
  });
}

const difference = (a, b) => a.data.reduce((sum, value, n) => sum + Math.abs(value - b.data[n]), 0) / a.data.length;
const changed = (before, now) => before.map((slice, n) => difference(slice, now[n]) > 0.3);
const point = (page) => page.evaluate(() => globalThis.layersplat.slices().point);
const canvas = (page, n) => page.locator("#slices canvas").nth(n);
const openPanel = (page) => page.locator("summary", { hasText: "Slices" }).click();

describe("slices", () => {
  on("three show the volume beside the picture, and go away again", async (page, shown) => {
    assert.ok(shown.every((slice) => measured(slice).mean[0] > 3));
    assert.ok(shown.every((slice) => difference({ ...slice, data: slice.data.map((v, n) => (n % 4 === 3 ? v : slice.data[n - (n % 4)])) }, slice) < 0.1), "grey");
    const [picture, first] = await Promise.all([page.locator("#picture").boundingBox(), canvas(page, 0).boundingBox()]);
    assert.ok(picture.x + picture.width <= first.x + 1, "beside each other");
    await page.keyboard.press("v");
    await refined(page);
    assert.ok(await page.locator("#slices").isHidden());
    assert.ok((await page.locator("#picture").boundingBox()).width > picture.width);
  });

  on("a click moves the crosshair that all share", async (page, first) => {
    const before = await point(page);
    const box = await canvas(page, 0).boundingBox();
    await page.mouse.click(box.x + box.width * 0.58, box.y + box.height * 0.4);
    const now = await slices(page);
    const after = await point(page);
    // The first slice is perpendicular to z: it stays, and the others move.
    assert.deepEqual([after[0] > before[0] + 1, after[1] > before[1] + 1, after[2] === before[2]], [true, true, true]);
    assert.deepEqual(changed(first, now), [false, true, true]);
    const place = await page.evaluate(() => globalThis.layersplat.slices().pixel(0, globalThis.layersplat.slices().point));
    const size = await canvas(page, 0).evaluate((element) => [element.width, element.height]);
    assert.ok(Math.abs(place[0] / size[0] - 0.58) < 0.01 && Math.abs(place[1] / size[1] - 0.4) < 0.01, `${place}`);
  });

  on("dragging follows the hand, and the line of the crosshair is drawn", async (page) => {
    const box = await canvas(page, 1).boundingBox();
    const at = (x, y) => [box.x + box.width * x, box.y + box.height * y];
    await page.mouse.move(...at(0.5, 0.5));
    await page.mouse.down();
    for (let n = 1; n <= 5; n += 1) await page.mouse.move(...at(0.5 - 0.03 * n, 0.5 + 0.02 * n));
    await page.mouse.up();
    await slices(page);
    // Columns of the picture in which the upright line's colour is: that of the third plane.
    const column = await canvas(page, 1).evaluate((element) => {
      const { width, height } = element;
      const { data } = element.getContext("2d").getImageData(0, 2, width, 1);
      let best = 0;
      for (let x = 0; x < width; x += 1) if (data[4 * x + 2] - data[4 * x] > data[4 * best + 2] - data[4 * best]) best = x;
      return height > 0 ? best / width : -1;
    });
    assert.ok(Math.abs(column - 0.35) < 0.02, `${column}`);
  });

  on("the wheel and Page Up move the slice", async (page, first) => {
    const before = await point(page);
    const box = await canvas(page, 0).boundingBox();
    await page.mouse.move(box.x + 5, box.y + 5);
    await page.mouse.wheel(0, -300);
    await page.waitForFunction((z) => globalThis.layersplat.slices().point[2] > z, before[2]);
    const turned = await slices(page);
    assert.deepEqual(changed(first, turned), [true, false, false]);
    assert.ok(Math.abs((await point(page))[2] - before[2] - 3) < 1e-6);
    await canvas(page, 0).focus();
    await page.keyboard.press("PageDown");
    await page.keyboard.press("PageDown");
    await page.keyboard.press("PageDown");
    await page.keyboard.press("ArrowLeft");
    await page.waitForFunction((x) => globalThis.layersplat.slices().point[0] < x, before[0]);
    const after = await point(page);
    assert.ok(Math.abs(after[2] - before[2]) < 1e-6 && Math.abs(after[0] - before[0] + 1) < 1e-6, `${after}`);
  });

  on("the right button changes the window, and numbers do", async (page, first) => {
    const window = () => page.evaluate(() => [...globalThis.layersplat.slices().own.window]);
    const before = await window();
    const box = await canvas(page, 0).boundingBox();
    await page.mouse.move(box.x + 20, box.y + 20);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(box.x + 60, box.y + 20, { steps: 4 });
    await page.mouse.move(box.x + 60, box.y + 50, { steps: 4 });
    await page.mouse.up({ button: "right" });
    const now = await slices(page);
    const after = await window();
    assert.ok(after[1] > before[1] * 1.1 && after[0] !== before[0], `${before} ${after}`);
    assert.deepEqual(changed(first, now), [true, true, true]);
    await openPanel(page);
    await page.locator("#slices-level").fill(String(before[0]));
    await page.locator("#slices-width").fill(String(before[1]));
    await page.locator("#slices-width").press("Enter");
    const again = await slices(page);
    assert.ok(again.every((slice, n) => difference(slice, first[n]) < 0.3), "the window by numbers");
  });

  on("colours follow the transfer function, and kernels and planes change the slices", async (page, first) => {
    await openPanel(page);
    await page.locator("#slices-colors").selectOption("colors");
    const colored = await slices(page);
    assert.deepEqual(changed(first, colored), [true, true, true]);
    await page.locator("#maps button").first().click();
    await refined(page);
    assert.ok(changed(colored, await slices(page)).some(Boolean), "another colour map");
    await page.locator("#slices-colors").selectOption("opacity");
    const faint = await slices(page);
    await page.locator("#slices-thickness").fill("30");
    await page.locator("#slices-thickness").press("Enter");
    const dense = await slices(page);
    assert.ok(measured(dense[0]).mean[0] + measured(dense[0]).mean[1] > measured(faint[0]).mean[0] + measured(faint[0]).mean[1]);
    await page.locator("#slices-colors").selectOption("window");
    await page.locator("#slices-planes").selectOption("camera");
    const facing = await slices(page);
    assert.deepEqual(changed(first, facing), [true, true, true]);
    await page.locator("#picture").focus();
    await page.keyboard.press("ArrowLeft");
    await refined(page);
    assert.ok(changed(facing, await slices(page))[0], "planes of the camera turn with it");
  });

  on("the crosshair's place and value are shown, and set by numbers", async (page, first) => {
    await openPanel(page);
    const value = await page.locator("#slices-value").textContent();
    assert.ok(Number.isFinite(Number(value)), value);
    await page.locator("#slices-z").fill("30");
    await page.locator("#slices-z").press("Enter");
    const now = await slices(page);
    assert.deepEqual([(await point(page))[2], changed(first, now)[0]], [30, true]);
    assert.match(await page.locator(".slice p").first().textContent(), /^z 30\.0$/);
    // The crosshair stays in the volume.
    await page.locator("#slices-z").fill("1000");
    await page.locator("#slices-z").press("Enter");
    await slices(page);
    assert.equal((await point(page))[2], 47.5);
  });

  on("undo, reset and the address hold them", async (page, first) => {
    const box = await canvas(page, 1).boundingBox();
    await page.mouse.click(box.x + box.width * 0.6, box.y + box.height * 0.35);
    const moved = await slices(page);
    const place = await point(page);
    await page.keyboard.press("Control+z");
    const undone = await slices(page);
    assert.ok(undone.every((slice, n) => difference(slice, first[n]) < 0.05), "undone");
    await page.keyboard.press("Control+y");
    const redone = await slices(page);
    assert.ok(redone.every((slice, n) => difference(slice, moved[n]) < 0.05), "redone");
    await reload(page);
    await refined(page);
    const again = await slices(page);
    assert.ok(again.every((slice, n) => difference(slice, moved[n]) < 0.05), "after reloading");
    assert.deepEqual(await point(page), place);
    await page.keyboard.press("r");
    await refined(page);
    assert.ok(await page.locator("#slices").isHidden(), "the first view has none");
  });

  on("a still page gets no slices", async (page) => {
    const pictures = () => page.evaluate(() => globalThis.layersplat.connection().pictures);
    const before = await pictures();
    await page.waitForTimeout(1200);
    assert.equal(await pictures(), before);
  });

  on("they fit a narrow page, and axe finds nothing", async (page) => {
    const [picture, first, last] = await Promise.all([
      page.locator("#picture").boundingBox(), canvas(page, 0).boundingBox(), canvas(page, 2).boundingBox(),
    ]);
    assert.ok(first.y >= picture.y + picture.height - 1 && last.x + last.width <= 361 && first.width > 100);
    const axe = await readFile(createRequire(import.meta.url).resolve("axe-core"), "utf8");
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => globalThis.axe.run());
    assert.deepEqual(violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)]), []);
  }, { viewport: { width: 360, height: 640 } });
});
