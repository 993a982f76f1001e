// Several fields and labels, as a user shows and hides them.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { answered, isDifferent, isSame, pages, pagesIn, reload, set, state } from "./shared.js";
import { measured, refined } from "./viewer.js";

const LABELS = await readFile(new URL("../../formats/files/labels/layers.seg.nrrd", import.meta.url));

const two = pages("builtin:hydrogen@32", "--with", "builtin:gyroid@32,color=#3388ff,opacity=p60:0,p99:0.1");

/** Labels of the left and the right half of 32³ voxels. */
const HALVES = Uint8Array.from({ length: 32 ** 3 }, (_, n) => (n % 32 < 16 ? 3 : 7));

const labelled = pagesIn({ "layers.seg.nrrd": LABELS }, "layers.seg.nrrd");
const tints = ["--label-colors", "halves_32x32x32_uint8.raw", "--label", "3:#ff0000", "--label", "7:#0000ff"];
const colored = pagesIn({ "halves_32x32x32_uint8.raw": HALVES }, "builtin:hydrogen@32", ...tints);

two("channels are hidden, weighed and coloured, and undo takes it back", async (page, first) => {
  const second = page.locator("#channels li").nth(1);
  assert.equal(await second.locator(".check").textContent(), "gyroid@32");
  await second.locator("[type=checkbox]").uncheck();
  const hidden = await refined(page);
  isDifferent(hidden, first, "a hidden channel");
  await second.locator("[type=checkbox]").check();
  isSame(await refined(page), first, "shown again");
  await set(page, "#channels li:nth-child(2) [type=number]", 20);
  isDifferent(await refined(page), first, "a factor");
  await page.locator("#undo").click();
  isSame(await refined(page), first, "undone");
  await set(page, "#channels li:nth-child(2) [type=color]", "#ff0000");
  const recolored = await refined(page);
  const red = measured(recolored).mean;
  const blue = measured(first).mean;
  assert.ok(red[0] > blue[0] + 2 && red[2] < blue[2] - 2, `${red} ${blue}`);
  // The address keeps all of it.
  await reload(page);
  isSame(await refined(page), recolored, "reloaded");
  assert.equal((await state(page)).look.channels[1].color, "#ff0000");
  assert.deepEqual((await state(page)).others[0].colors[0][1], [1, 0, 0]);
});

two("the curve is that of the chosen channel", async (page, first) => {
  await page.locator("#field").selectOption("1");
  assert.ok(await page.locator("#point-value").inputValue());
  await answered(page, () => page.locator("#maps button").first().click());
  isDifferent(await refined(page), first, "a map of the second channel");
  const { transfer, others } = await state(page);
  assert.ok(others[0].colors.length > 4 && transfer.name === "automatic", transfer.name);
  await page.locator("#field").selectOption("0");
  assert.deepEqual((await state(page)).others, others);
});

two("what several fields do not have is disabled, with a reason", async (page) => {
  // Playwright's isDisabled is that of the list.
  assert.ok(await page.locator("#quality option[value=paper]").evaluate((option) => option.disabled));
  assert.match(await page.locator("#quality option[value=paper]").getAttribute("title"), /one channel/);
  await page.locator("#picture").focus();
  await page.keyboard.press("v");
  assert.ok(await page.locator("#slices").isHidden());
});

two("the value of each channel is read under the cursor", async (page) => {
  await page.mouse.move(280, 300);
  await page.waitForFunction(() => document.getElementById("reading").textContent.includes("at"));
  assert.match(await page.locator("#reading").textContent(), /hydrogen@32 \S+, gyroid@32 \S+ at/);
});

labelled("labels are hidden and shown alone, and named under the cursor", async (page, first) => {
  const rows = page.locator("#channels li");
  const name = await rows.first().locator(".check").textContent();
  await rows.first().locator("[type=checkbox]").uncheck();
  isDifferent(await refined(page), first, "a hidden label");
  await rows.first().getByRole("button").click();
  const alone = await refined(page);
  isDifferent(alone, first, "one label alone");
  assert.equal(await page.locator("#channels [type=checkbox]:checked").count(), 1);
  assert.ok(await page.locator("#curve").evaluate((curve) => curve.closest("[inert]") !== null || curve.inert));
  await page.locator("#labels-all").click();
  isSame(await refined(page), first, "all again");
  await rows.first().getByRole("button").click();
  await refined(page);
  const box = await page.locator("#picture").boundingBox();
  const { x, y } = measured(alone);
  const half = box.height / 2;
  await page.mouse.move(box.x + box.width / 2 + (x * box.width) / 2, box.y + half - y * half);
  await page.waitForFunction(() => document.getElementById("reading").textContent);
  assert.ok((await page.locator("#reading").textContent()).includes(name), await page.locator("#reading").textContent());
});

colored("labels that colour a scan are listed, hidden and coloured, and named beside the value", async (page, first) => {
  const rows = page.locator("#channels li");
  assert.equal(await page.locator("#channels-title").textContent(), "Labels");
  assert.equal(await rows.count(), 2);
  assert.match(await page.locator("#facts").textContent(), /voxels of uint8, 0 to \d+, 2 labels$/);
  await rows.nth(1).locator("[type=checkbox]").uncheck();
  const hidden = await refined(page);
  isDifferent(hidden, first, "a hidden label");
  assert.ok(measured(hidden).mean[2] < measured(first).mean[2] - 2, "less blue");
  await rows.nth(1).locator("[type=checkbox]").check();
  isSame(await refined(page), first, "shown again");
  await set(page, "#channels li:nth-child(2) [type=color]", "#00ff00");
  assert.ok(measured(await refined(page)).mean[1] > measured(first).mean[1] + 2, "green");
  await page.locator("#undo").click();
  isSame(await refined(page), first, "undone");
  // The curve is that of the scan.
  assert.ok(await page.locator("#curve").evaluate((curve) => curve.closest("[inert]") === null));
  const box = await page.locator("#picture").boundingBox();
  const { x, y } = measured(hidden);
  await page.mouse.move(box.x + box.width / 2 + (x * box.width) / 2, box.y + box.height / 2 - (y * box.height) / 2);
  await page.waitForFunction(() => document.getElementById("reading").textContent);
  assert.match(await page.locator("#reading").textContent(), /^label [37], value \S+ at /);
});
