// The page as a user uses it. Pictures are compared at rest, unless a test is about moving ones.

import assert from "node:assert/strict";
import { readFile, writeFile, mkdtemp } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { describe, test } from "node:test";
import { answered, isDifferent, isSame, pages, reload, section, set } from "./shared.js";
import { difference, drag, measured, open, pixels, refined, serve } from "./viewer.js";

/** Pages whose pictures are refined up to the mean of 16 frames, and pages in a fixed quality, whose tests take a fraction of the time. */
const onRefining = pages("builtin:hydrogen@48");
const on = pages("builtin:hydrogen@48", "--quality", "standard");

describe("opening", () => {
  onRefining("shows a picture, and the token has left the address", async (page, first) => {
    assert.ok(measured(first).mean.slice(0, 3).some((mean) => mean > 3));
    assert.ok(!page.url().includes("token"));
    assert.equal(await page.locator("#name").textContent(), "builtin:hydrogen@48");
    await page.goBack().catch(() => {});
    assert.ok(!page.url().includes("token"), page.url());
  });

  onRefining("a refined page gets no pictures", async (page) => {
    const count = () => page.evaluate(() => globalThis.layersplat.shown.pictures);
    const before = await count();
    await page.waitForTimeout(1500);
    assert.equal(await count(), before);
  });

  onRefining("reloading keeps view, look and curve", async (page) => {
    await drag(page, 90, 40);
    await section(page, "Look");
    await set(page, "#background", "#203040");
    await set(page, "#fade", 0.5);
    const before = await refined(page);
    await reload(page);
    isSame(await refined(page), before, "after reloading");
  });

  onRefining("a lost connection comes back with the same view", async (page) => {
    await drag(page, 60, -30);
    const before = await refined(page);
    const requested = await page.evaluate(() => {
      globalThis.layersplat.connection().socket.close();
      return globalThis.layersplat.requested();
    });
    await page.waitForFunction((id) => globalThis.layersplat.requested() > id, requested);
    isSame(await refined(page), before, "after the connection came back");
    assert.ok(await page.locator("#problem").isHidden());
  });

  onRefining("a damaged view in the address is said, and the first view stands", async (page, first) => {
    for (const damaged of ["xyz", "e30", btoa(JSON.stringify({ look: { blend: 7 } })).replaceAll("=", ""), btoa(JSON.stringify({ camera: { azimuth: null } })).replaceAll("=", "")]) {
      await page.evaluate((hash) => { location.hash = hash; location.reload(); }, damaged);
      await page.waitForFunction(() => globalThis.layersplat?.shown.pictures > 0);
      isSame(await refined(page), first, damaged);
      if (damaged !== "e30") assert.match(await page.locator("#problem").textContent(), /view in the address/);
    }
  });

  onRefining("names that no server knows lead to the first view, too", async (page, first) => {
    const look = await page.evaluate(() => globalThis.layersplat.state().look);
    const hash = Buffer.from(JSON.stringify({ look: { ...look, blend: "nothing" } })).toString("base64url");
    await page.evaluate((to) => { location.hash = to; location.reload(); }, hash);
    await page.waitForFunction(() => globalThis.layersplat?.shown.pictures > 0);
    isSame(await refined(page), first, "the first view");
  });

  onRefining("a new address keeps the view of an old one", async (page) => {
    await drag(page, 90, 40);
    const before = await refined(page);
    await page.waitForTimeout(500);
    const fragment = new URL(page.url()).hash;
    const again = await page.context().newPage();
    await again.goto(onRefining.server().url + fragment);
    isSame(await refined(again), before, "from the new address");
    assert.ok(!again.url().includes("token"));
  });

  test("a page says that another run has no access for it", async () => {
    const first = await serve("builtin:hydrogen@16", "--quality", "standard");
    const page = await open(on.browser(), first.url);
    await first.end();
    const { port } = new URL(first.url);
    const second = await serve("builtin:hydrogen@16", "--port", port);
    await page.locator("#problem", { hasText: /Another run/ }).waitFor();
    await page.context().close();
    await second.end();
  });

  test("two pages have views of their own", async () => {
    const [a, b] = [await open(on.browser(), onRefining.server().url), await open(on.browser(), onRefining.server().url)];
    const before = await pixels(b);
    await drag(a, 120, 0);
    isDifferent(await refined(a), before, "the first page turned");
    isSame(await refined(b), before, "the second did not");
    await Promise.all([a.context().close(), b.context().close()]);
  });
});

describe("turning", () => {
  on("a drag turns, and moving pictures come while it lasts", async (page, first) => {
    await page.mouse.move(280, 300);
    await page.mouse.down();
    for (let n = 1; n <= 10; n += 1) {
      await page.mouse.move(280 + 12 * n, 300);
      await page.waitForTimeout(20);
    }
    // The first moving picture may be that of the first movement, which is small.
    await page.waitForFunction(() => {
      const viewer = globalThis.layersplat;
      return viewer.shown.step === "moving" && viewer.shown.id === viewer.requested();
    });
    isDifferent(await pixels(page), first, "while dragging");
    await page.mouse.up();
    isDifferent(await refined(page), first, "after dragging");
  });

  on("drags go on over the poles, and back again", async (page, first) => {
    const elevations = [];
    for (let n = 0; n < 4; n += 1) {
      await drag(page, 0, 150);
      elevations.push(await page.evaluate(() => globalThis.layersplat.state().camera.elevation));
    }
    isDifferent(await refined(page), first, "beyond the pole");
    for (let n = 0; n < 4; n += 1) await drag(page, 0, -150);
    isSame(await refined(page), first, `back again: ${elevations}`);
    // 20 and four times 45 degrees: 65, 110, 155, 200.
    assert.deepEqual(elevations.map(Math.round), [65, 70, 25, -20]);
  });

  on("Shift and the right button pan with the hand", async (page, first) => {
    const width = await page.locator("#picture").evaluate((canvas) => canvas.clientWidth);
    await drag(page, 100, 0, { key: "Shift" });
    const moved = measured(await refined(page)).x - measured(first).x;
    assert.ok(Math.abs(moved - 200 / width) < 0.04, `${moved} of ${200 / width}`);
    await drag(page, -100, 0, { button: "right" });
    isSame(await refined(page), first, "panned back");
  });

  on("the wheel zooms to the cursor", async (page, first) => {
    await page.mouse.move(120, 120);
    await page.mouse.wheel(0, -400);
    const near = await refined(page);
    assert.ok(measured(near).spread > 1.2 * measured(first).spread);
    // What was at the cursor stays there, so the middle moves away from it.
    assert.ok(measured(near).x > measured(first).x + 0.05 && measured(near).y < measured(first).y - 0.05);
    await page.mouse.wheel(0, 400);
    isSame(await refined(page), first, "zoomed back");
  });

  on("Alt rolls about the middle", async (page) => {
    await drag(page, 120, 0, { key: "Alt", from: [280, 120] });
    const roll = await page.evaluate(() => globalThis.layersplat.state().camera.roll);
    assert.ok(Math.abs(roll) > 10, `${roll}`);
  });

  on("keys turn, pan, zoom, roll, fit and reset", async (page, first) => {
    await page.locator("#picture").focus();
    for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+", ","]) {
      const before = await pixels(page);
      await page.keyboard.press(key);
      isDifferent(await refined(page), before, key);
    }
    await answered(page, () => page.keyboard.press("f"));
    const fitted = measured(await refined(page));
    assert.ok(Math.abs(fitted.x) < 0.1 && Math.abs(fitted.y) < 0.1);
    await page.keyboard.press("r");
    isSame(await refined(page), first, "reset");
  });

  on("six sides and two corners, on keys, buttons and the cube", async (page) => {
    const seen = [];
    for (const key of ["1", "2", "5", "7", "8"]) {
      await page.keyboard.press(key);
      seen.push(await refined(page));
    }
    isDifferent(seen[0], seen[2], "front and above");
    isDifferent(seen[2], seen[3], "above and a corner");
    await page.locator("#sides button").nth(0).click();
    isSame(await refined(page), seen[0], "the button of the front");
    await page.keyboard.press("7");
    await refined(page);
    const box = await page.locator("#cube").boundingBox();
    await page.mouse.click(box.x + box.width * 0.5, box.y + box.height * 0.2);
    await refined(page);
    assert.equal(await page.evaluate(() => globalThis.layersplat.state().camera.elevation), 90);
  });

  on("perspective and parallel", async (page, first) => {
    await page.locator("#picture").focus();
    await page.keyboard.press("o");
    const perspective = await refined(page);
    assert.ok(difference(perspective, first) > 0.1);
    assert.equal(await page.locator("#projection").getAttribute("aria-pressed"), "true");
    await page.locator("#projection").click();
    isSame(await refined(page), first, "parallel again");
  });

  on("two fingers zoom", async (page, first) => {
    const finger = (type, id, x, y) => page.locator("#picture").evaluate((canvas, [kind, pointerId, clientX, clientY]) => {
      canvas.setPointerCapture = () => {};
      canvas.dispatchEvent(new PointerEvent(kind, { pointerId, clientX, clientY, pointerType: "touch", bubbles: true, buttons: 1 }));
    }, [type, id, x, y]);
    await finger("pointerdown", 11, 250, 300);
    await finger("pointerdown", 12, 310, 300);
    for (let n = 1; n <= 4; n += 1) {
      await finger("pointermove", 11, 250 - 10 * n, 300);
      await finger("pointermove", 12, 310 + 10 * n, 300);
    }
    await finger("pointerup", 11, 210, 300);
    await finger("pointerup", 12, 350, 300);
    assert.ok(measured(await refined(page)).spread > 1.3 * measured(first).spread);
  });
});

describe("curve", () => {
  const points = (page) => page.evaluate(() => globalThis.layersplat.state().transfer.opacities);

  on("a point is dragged, and the picture follows; undo and redo", async (page, first) => {
    const count = (await points(page)).length;
    const box = await page.locator("#curve").boundingBox();
    await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.15);
    await page.mouse.down();
    assert.equal((await points(page)).length, count + 1);
    for (let n = 1; n <= 5; n += 1) await page.mouse.move(box.x + box.width * 0.5 - 12 * n, box.y + box.height * 0.15);
    // The first moving picture may be that of the first movement, which is small.
    await page.waitForFunction(() => {
      const viewer = globalThis.layersplat;
      return viewer.shown.step === "moving" && viewer.shown.id === viewer.requested();
    });
    isDifferent(await pixels(page), first, "while dragging");
    await page.mouse.up();
    const changed = await refined(page);
    isDifferent(changed, first, "a new point");
    await page.keyboard.press("Control+z");
    isSame(await refined(page), first, "undone");
    assert.equal((await points(page)).length, count);
    await page.keyboard.press("Control+y");
    isSame(await refined(page), changed, "redone");
  });

  on("exact numbers and colours are typed", async (page, first) => {
    await page.locator("#curve").focus();
    await page.keyboard.press("ArrowRight");
    await page.locator("#point-opacity").fill("0.625");
    await page.locator("#point-opacity").press("Tab");
    isDifferent(await refined(page), first, "opacity");
    assert.ok((await points(page)).some(([, opacity]) => opacity === 0.625));
    await page.locator("#colors").focus();
    const count = await page.evaluate(() => globalThis.layersplat.state().transfer.colors.length);
    for (let n = 0; n < count; n += 1) {
      await set(page, "#point-color", "#ff0000");
      await page.locator("#colors").focus();
      await page.keyboard.press("ArrowRight");
    }
    const { mean } = measured(await refined(page));
    assert.ok(mean[0] > 2 * mean[1] && mean[0] > 2 * mean[2], `${mean}`);
  });

  on("keys choose, move, add and delete points", async (page) => {
    await page.locator("#curve").focus();
    const count = (await points(page)).length;
    await page.keyboard.press("Insert");
    assert.equal((await points(page)).length, count + 1);
    const before = await points(page);
    await page.keyboard.press("Alt+ArrowUp");
    await page.keyboard.press("Alt+ArrowRight");
    assert.notDeepEqual(await points(page), before);
    await page.keyboard.press("Delete");
    assert.equal((await points(page)).length, count);
    await page.locator("#point-delete").click();
    assert.equal((await points(page)).length, count - 1);
  });

  on("shift, widen and fade", async (page, first) => {
    for (const [id, value] of [["#shift", 0.4], ["#widen", 0.5], ["#fade", -0.9]]) {
      await set(page, id, value);
      isDifferent(await refined(page), first, id);
      assert.equal(await page.locator(id).inputValue(), "0");
      await page.locator("#undo").click();
      isSame(await refined(page), first, `${id} undone`);
    }
    await set(page, "#fade", -1);
    assert.deepEqual(measured(await refined(page)).mean.slice(0, 3), [0, 0, 0]);
  });

  on("palettes, presets and colour maps", async (page, first) => {
    const choose = (button) => answered(page, () => page.locator(button).click());
    await choose('#palettes button[title="vivid"]');
    const vivid = await refined(page);
    isDifferent(vivid, first, "vivid");
    await choose('#presets button[title^="simulation"]');
    isDifferent(await refined(page), vivid, "preset");
    await choose("#initial");
    isSame(await refined(page), first, "as at the start");
    // The command began with the automatic one in the first palette's colours.
    await choose("#presets button >> nth=0");
    await choose("#automatic");
    isSame(await refined(page), first, "automatic again");
    // Previews have the colours of the server's tables.
    const colorsOf = (id) => page.locator(`${id} canvas`).evaluateAll((canvases) => canvases.map((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, 1);
      return new Set(Array.from({ length: canvas.width }, (_, n) => data.slice(4 * n, 4 * n + 3).join())).size;
    }));
    for (const id of ["#palettes", "#presets", "#maps"]) {
      const counts = await colorsOf(id);
      assert.ok(counts.length >= 4 && counts.every((count) => count > 1), `${id}: ${counts}`);
    }
    const before = await points(page);
    await page.locator("#maps button").nth(2).click();
    isDifferent(await refined(page), first, "a colour map");
    assert.deepEqual(await points(page), before, "keeps the opacities");
  });

  on("files are loaded and saved", async (page, first) => {
    const folder = await mkdtemp(join(tmpdir(), "layersplat-"));
    const file = join(folder, "mine.csv");
    await writeFile(file, "0,0,0,1,0\n40,0,0,1,0\n200,0,0,1,0.3\n");
    await page.locator("#transfer-file").setInputFiles(file);
    await page.waitForFunction(() => globalThis.layersplat.state().transfer.name === "mine.csv");
    const blue = await refined(page);
    isDifferent(blue, first, "loaded");
    assert.ok(measured(blue).mean[2] > measured(blue).mean[0]);
    for (const [format, word] of [["json", "RGBPoints"], ["vp.json", "volumeProperties"], ["csv", "200,0,0,1,0.3"]]) {
      const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#save-transfer").selectOption(format)]);
      assert.equal(download.suggestedFilename(), `layersplat.${format}`);
      assert.ok((await readFile(await download.path(), "utf8")).includes(word), format);
    }
    await writeFile(file, "this is no curve");
    await page.locator("#transfer-file").setInputFiles(file);
    await page.locator("#problem").waitFor({ state: "visible" });
    assert.match(await page.locator("#problem").textContent(), /mine\.csv.*format/);
  });
});

describe("light and look", () => {
  on("the ball moves the light; shadows, occlusion and shading", async (page, first) => {
    await section(page, "Light");
    const box = await page.locator("#ball").boundingBox();
    await page.mouse.move(box.x + 48, box.y + 48);
    await page.mouse.down();
    for (let n = 1; n <= 5; n += 1) await page.mouse.move(box.x + 48 - 8 * n, box.y + 48);
    await page.mouse.up();
    const left = await refined(page);
    assert.ok(difference(left, first) > 0.2, "from the left");
    await page.locator("#ball").focus();
    for (let n = 0; n < 12; n += 1) await page.keyboard.press("ArrowRight");
    assert.ok(difference(await refined(page), left) > 0.2, "by keys");
    let before = await refined(page);
    for (const id of ["#shadows", "#ambient-occlusion", "#shading"]) {
      await page.locator(id).click();
      const now = await refined(page);
      assert.ok(difference(now, before) > 0.05, id);
      before = now;
    }
    assert.ok(await page.locator("#shadows").isDisabled(), "nothing is lit");
  });

  on("blend modes, iso-value, quality, kernel and background", async (page, first) => {
    await section(page, "Look");
    await page.locator("#blend").selectOption("maximum");
    isDifferent(await refined(page), first, "maximum");
    await page.locator("#blend").selectOption("iso");
    const surface = await refined(page);
    isDifferent(surface, first, "iso");
    await set(page, "#iso", 40);
    isDifferent(await refined(page), surface, "another iso-value");
    await page.locator("#blend").selectOption("composite");
    isSame(await refined(page), first, "composite again");
    await page.locator("#quality").selectOption("draft");
    const draft = await refined(page);
    await page.locator("#quality").selectOption("");
    assert.ok(difference(await refined(page), draft) > 0, "refined");
    await page.locator("#kernel").selectOption("linear");
    await refined(page);
    await set(page, "#background", "#ff8000");
    const { data } = await refined(page);
    assert.deepEqual(data.slice(0, 4), [255, 128, 0, 255]);
    await page.locator("#transparent").click();
    assert.equal((await refined(page)).data[3], 0);
    await drag(page, 50, 0);
    assert.equal((await refined(page)).data[3], 0);
  });
});

describe("cutting", () => {
  on("the crop box hides a half", async (page, first) => {
    await page.keyboard.press("1");
    const front = await refined(page);
    await section(page, "Cutting");
    await page.getByLabel("x from, number").fill("24");
    await page.getByLabel("x from, number").press("Tab");
    const half = await refined(page);
    assert.ok(measured(half).x > measured(front).x + 0.05, "the left half is gone");
    await page.locator("#uncrop").click();
    isSame(await refined(page), front, "whole again");
    void first;
  });

  on("clip planes are added, flipped, moved and deleted", async (page, first) => {
    await section(page, "Cutting");
    await page.locator("#add-clip").click();
    const clipped = await refined(page);
    isDifferent(clipped, first, "clipped");
    await page.locator("#clips").getByRole("button", { name: "Flip" }).click();
    isDifferent(await refined(page), clipped, "flipped");
    await page.getByLabel("Plane 1, along its normal").evaluate((slider) => {
      slider.value = "-0.9";
      slider.dispatchEvent(new Event("input"));
      slider.dispatchEvent(new Event("change"));
    });
    isSame(await refined(page), first, "moved away");
    await page.locator("#clips").getByRole("button", { name: "Delete" }).click();
    assert.equal(await page.locator(".clip").count(), 0);
  });
});

describe("layout", () => {
  const scale = (page) => page.evaluate(() => globalThis.layersplat.state().camera.projection.parallel_scale);

  on("what was fitted follows sides and slices until it is zoomed", async (page) => {
    const wide = await scale(page);
    await page.keyboard.press("v");
    await refined(page);
    const narrow = await scale(page);
    assert.ok(narrow > wide * 1.05, `${narrow} of ${wide}: the picture is narrower`);
    await page.keyboard.press("v");
    await refined(page);
    assert.ok(Math.abs(await scale(page) - wide) < 1e-3 * wide);
    await page.keyboard.press("+");
    await refined(page);
    const zoomed = await scale(page);
    await page.keyboard.press("v");
    await refined(page);
    assert.equal(await scale(page), zoomed);
  });

  on("a picture keeps its shape between a change of size and the next one", async (page, first) => {
    const round = measured(first).spread * (await page.evaluate(() => document.getElementById("picture").width));
    // No next picture comes.
    await page.evaluate(() => { globalThis.layersplat.connection().receive = () => {}; });
    await page.setViewportSize({ width: 1200, height: 600 });
    await page.waitForFunction(() => document.getElementById("picture").width > 800);
    const now = measured(await pixels(page)).spread * (await page.evaluate(() => document.getElementById("picture").width));
    assert.ok(Math.abs(now - round) < 0.02 * round, `${now} pixels of ${round}`);
  });

  on("zoom has ends, handles are reachable, and the keys begin at their top", async (page) => {
    const { diagonal } = { diagonal: 48 * Math.sqrt(3) };
    for (let n = 0; n < 12; n += 1) await page.mouse.move(280, 300).then(() => page.mouse.wheel(0, 20000));
    assert.ok(await scale(page) <= 51 * diagonal, `${await scale(page)}`);
    for (let n = 0; n < 12; n += 1) await page.mouse.wheel(0, -20000);
    assert.ok(await scale(page) >= 0.9e-5 * diagonal, `${await scale(page)}`);
    await answered(page, () => page.keyboard.press("r"));
    await section(page, "Cutting");
    await page.keyboard.press("f");
    await refined(page);
    await page.locator("#handles").click();
    await refined(page);
    const beyond = await page.evaluate(() => globalThis.layersplat.state().camera.projection.parallel_scale);
    assert.ok(beyond > 24, `${beyond}: every face is in the picture`);
    await page.keyboard.press("?");
    assert.equal(await page.locator("#help").evaluate((dialog) => dialog.scrollTop), 0);
  }, { viewport: { width: 900, height: 400 } });
});

describe("keeping", () => {
  on("a picture is saved, and its command copied", async (page) => {
    await section(page, "Save");
    await page.locator("#save-width").fill("300");
    await page.locator("#save-height").fill("200");
    const [picture] = await Promise.all([page.waitForEvent("download"), page.locator("#save").click()]);
    const bytes = await readFile(await picture.path());
    assert.deepEqual([picture.suggestedFilename(), bytes.readUInt32BE(16), bytes.readUInt32BE(20)], ["layersplat.png", 300, 200]);
    const [numbers] = await Promise.all([
      page.waitForEvent("download", (download) => download.suggestedFilename().endsWith("exr")),
      page.locator("#save-format").selectOption("exr").then(() => page.locator("#save").click()),
    ]);
    assert.deepEqual([...(await readFile(await numbers.path())).subarray(0, 4)], [0x76, 0x2f, 0x31, 0x01], "the magic number of EXR");
    await page.locator("#save-format").selectOption("png");
    const [transfer] = await Promise.all([page.waitForEvent("download"), page.locator("#copy").click()]);
    assert.equal(transfer.suggestedFilename(), "layersplat.json");
    const line = await page.locator("#command").inputValue();
    assert.match(line, /^layersplat render builtin:hydrogen@48 --transfer layersplat\.json .*--size 300x200.* -o layersplat\.png$/);
    const [again] = await Promise.all([page.waitForEvent("download"), page.locator("#copy-python").click()]);
    assert.equal(again.suggestedFilename(), "layersplat.json");
    const program = await page.locator("#command").inputValue();
    assert.match(program, /^import layersplat\n[^]*TransferFunction\.open\("layersplat\.json", volume\)[^]*\(300, 200\), settings/);
    await page.locator("#save-samples").fill("99");
    await page.locator("#save").click();
    await page.locator("#problem", { hasText: /1 to 16/ }).waitFor();
  });
});

describe("everybody", () => {
  on("works by keyboard alone", async (page, first) => {
    await page.keyboard.press("?");
    assert.ok(await page.locator("#help").isVisible());
    await page.keyboard.press("Escape");
    assert.ok(await page.locator("#help").isHidden());
    // Every control is reached by the Tab key.
    await page.evaluate(() => document.querySelectorAll("details").forEach((part) => { part.open = true; }));
    const reached = new Set();
    for (let n = 0; n < 180; n += 1) {
      await page.keyboard.press("Tab");
      reached.add(await page.evaluate(() => document.activeElement?.id || document.activeElement?.ariaLabel || document.activeElement?.textContent));
    }
    for (const id of ["picture", "fold", "reset", "fit", "momentum", "automatic", "tent", "range-low", "flip", "measure", "legend", "handles", "add-light", "gradient", "save-format", "copy-python", "curve", "colors", "point-value", "shift", "ball", "shadows", "blend", "quality",
      "background", "x from", "add-clip", "save", "copy"]) {
      assert.ok(reached.has(id), `${id} of ${[...reached].join(", ")}`);
    }
    // Keys of the page count where no text is typed.
    for (let n = 0; n < 300 && (await page.evaluate(() => document.activeElement?.id)) !== "picture"; n += 1) await page.keyboard.press("Tab");
    await page.keyboard.press("p");
    assert.ok(await page.locator("#panel").isHidden());
    await refined(page);
    await page.keyboard.press("p");
    await page.keyboard.press("r");
    isSame(await refined(page), first, "as before");
  });

  for (const colorScheme of ["light", "dark"]) {
    on(`axe finds nothing, ${colorScheme}`, async (page) => {
      await page.evaluate(() => document.querySelectorAll("details").forEach((part) => { part.open = true; }));
      const axe = await readFile(createRequire(import.meta.url).resolve("axe-core"), "utf8");
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => globalThis.axe.run());
      const found = violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target).join("; ")}`);
      assert.deepEqual(found, []);
    }, { colorScheme });
  }

  on("fits into 360 pixels", async (page, first) => {
    assert.ok(await page.locator("#panel").isHidden(), "folded at first");
    await page.locator("#fold").click();
    await page.evaluate(() => document.querySelectorAll("details").forEach((part) => { part.open = true; }));
    const wide = await page.evaluate(() => {
      const all = [...document.querySelectorAll("#panel *")].filter((item) => !item.closest(".strip"));
      const beyond = all.filter((item) => item.getBoundingClientRect().right > innerWidth + 0.5);
      return [document.documentElement.scrollWidth, beyond.map((item) => item.id || item.tagName)];
    });
    assert.deepEqual(wide, [360, []]);
    const before = await refined(page);
    await drag(page, 80, 0, { from: [120, 120] });
    isDifferent(await refined(page), before, "turned above the panel");
    void first;
  }, { viewport: { width: 360, height: 720 } });
});
