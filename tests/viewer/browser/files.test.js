// Other volumes, as a user opens them.

import assert from "node:assert/strict";
import { tmpdir } from "node:os";
import { pagesIn } from "./shared.js";
import { measured, refined } from "./viewer.js";

/** A cube whose values grow along x. */
const cube = (side) => Buffer.from(Array.from({ length: side ** 3 }, (_, n) => ((n % side) * 255) / (side - 1)));

const on = pagesIn({ "cube_16x16x16_uint8.raw": cube(16), "notes.txt": "nothing" });

const named = (page, name) => page.waitForFunction((text) => document.getElementById("name").textContent === text, name);

on("the folder's volumes and built-in ones are listed, and open", async (page) => {
  await page.locator("summary", { hasText: "Volume" }).click();
  const offered = await page.locator("#offered option").allTextContents();
  assert.ok(offered.includes("cube_16x16x16_uint8.raw") && offered.includes("torus-knot") && !offered.includes("notes.txt"), offered.join());
  await page.locator("#offered").selectOption("cube_16x16x16_uint8.raw");
  await named(page, "cube_16x16x16_uint8.raw");
  assert.ok(measured(await refined(page)).mean.slice(0, 3).some((mean) => mean > 3));
  // The state of the last volume is gone.
  assert.ok(await page.locator("#undo").isDisabled());
  await page.locator("#offered").selectOption("builtin:hydrogen");
  await named(page, "builtin:hydrogen");
  await refined(page);
});

on("a chosen file is sent and shown, and saved pictures name it", async (page) => {
  await page.locator("#volume-file").setInputFiles({ name: "my cube_12x12x12_uint8.raw", mimeType: "", buffer: cube(12) });
  await named(page, "my cube_12x12x12_uint8.raw");
  await refined(page);
  assert.ok((await page.locator("#facts").textContent()).includes("12 × 12 × 12"));
});

on("raw voxels without a size are asked for it", async (page) => {
  await page.locator("#volume-file").setInputFiles({ name: "Cube.raw", mimeType: "", buffer: cube(12) });
  await page.locator("#raw-dims").fill("12x12x13");
  assert.match(await page.locator("#raw-size").textContent(), /1,872 bytes.*1,728/);
  await page.locator("#raw-dims").fill("12 × 12 × 12");
  await page.locator("#raw button", { hasText: "Open" }).click();
  await named(page, "Cube_12x12x12_uint8.raw");
  await refined(page);
});

on("raw voxels behind a header, or in another byte order than usual, are read as the user states", async (page) => {
  const voxels = Buffer.alloc(100 + 2 * 12 ** 3);
  cube(12).forEach((value, n) => voxels.writeUInt16BE(value, 100 + 2 * n));
  // The name states a size that is not that of the file.
  await page.locator("#volume-file").setInputFiles({ name: "c_12x12x12_uint16.raw", mimeType: "", buffer: voxels });
  assert.match(await page.locator("#raw-size").textContent(), /3,456 bytes.*3,556/);
  await page.locator("#raw-header").fill("100");
  await page.locator("#raw-order").selectOption("big");
  await page.locator("#raw button", { hasText: "Open" }).click();
  await named(page, "c_12x12x12_uint16.raw");
  await refined(page);
  assert.match(await page.locator("#facts").textContent(), /uint16, 0 to 255/);
  await page.locator("#copy").evaluate((button) => button.click());
  await page.waitForFunction(() => document.getElementById("command").value);
  assert.match(await page.locator("#command").inputValue(), /--endian big --header-bytes 100/);
});

on("a file that is dropped onto the picture is shown, and one that is no volume is a sentence", async (page) => {
  const dropped = (name, bytes) => page.evaluate(([text, numbers]) => {
    const data = new DataTransfer();
    data.items.add(new File([new Uint8Array(numbers)], text));
    document.getElementById("picture").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, [name, [...bytes]]);
  await dropped("cube_8x8x8_uint8.raw", cube(8));
  await named(page, "cube_8x8x8_uint8.raw");
  await refined(page);
  await dropped("notes.txt", Buffer.from("nothing"));
  await page.waitForFunction(() => !document.getElementById("problem").hidden);
  const problem = await page.locator("#problem").textContent();
  assert.ok(problem.includes("notes.txt") && !problem.includes(tmpdir()), problem);
  assert.equal(await page.locator("#name").textContent(), "cube_8x8x8_uint8.raw");
});
