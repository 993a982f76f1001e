// Reading values, turning about points, handles in the picture, lights, and editing of several points. In a fixed quality, so that each
// picture at rest is one frame.

import assert from "node:assert/strict";
import { describe } from "node:test";
import { answered, DIFFERENT, isDifferent, isSame, pages, reload, SAME, section, set, state } from "./shared.js";
import { difference, drag, measured, pixels, refined } from "./viewer.js";

const on = pages("builtin:hydrogen@32", "--quality", "standard");

/** Opaque from a value of 60 on: what is seen has about that value. */
const OPAQUE = { name: "opaque", colors: [[0, [1, 1, 1]]], opacities: [[50, 0], [60, 1]] };

/** Loads a transfer function as a file. */
async function load(page, { colors, opacities }) {
  const rows = opacities.map(([value, opacity]) => `${[value, ...colors[0][1], opacity].join(",")}\n`).join("");
  await answered(page, () => page.locator("#transfer-file").setInputFiles({ name: "mine.csv", mimeType: "text/csv", buffer: Buffer.from(rows) }));
  return refined(page);
}

/** A place of the picture in pixels of the window. */
async function middle(page, dx = 0, dy = 0) {
  const { x, y, width, height } = await page.locator("#picture").boundingBox();
  return [x + width / 2 + dx, y + height / 2 + dy];
}

/** Pixels of the overlay that are not transparent. */
const marks = (page) => page.locator("#overlay").evaluate((canvas) => new Promise((resolve) => {
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    resolve(data.filter((value, n) => n % 4 === 3 && value > 0).length);
  }));
}));

const reading = async (page) => {
  await page.waitForFunction(() => document.getElementById("reading").textContent !== "");
  return page.locator("#reading").textContent();
};

describe("reading", () => {
  on("value and position under the cursor, and by keyboard", async (page) => {
    await load(page, OPAQUE);
    await page.mouse.move(...await middle(page, -40, 30));
    const text = await reading(page);
    const [, value, x, y, z] = text.match(/^value ([\d.]+) at ([-\d.]+), ([-\d.]+), ([-\d.]+) \(voxel/).map(Number);
    assert.ok(value > 50 && value < 90, text);
    assert.ok([x, y, z].every((place) => place >= 0 && place <= 31), text);
    await page.mouse.move(20, 20);
    assert.equal(await reading(page), "nothing is seen here");
    await page.locator("#picture").focus();
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => document.getElementById("reading").textContent.startsWith("value"));
  });

  on("the distance of two points", async (page) => {
    await load(page, OPAQUE);
    await page.keyboard.press("1");
    await refined(page);
    await section(page, "Reading");
    await page.locator("#measure").click();
    await page.mouse.click(...await middle(page, -50, 0));
    await page.locator("#distance", { hasText: "other end" }).waitFor();
    assert.ok(await marks(page) > 10, "one end is marked");
    await page.mouse.click(...await middle(page, 50, 0));
    await page.locator("#distance", { hasText: "units" }).waitFor();
    // At least the way across the picture: 100 pixels of its height.
    const across = (await state(page)).camera.projection.parallel_scale * (200 / await page.locator("#picture").evaluate((c) => c.clientHeight));
    const distance = parseFloat(await page.locator("#distance").textContent());
    assert.ok(distance >= across * 0.999 && distance < across + 32, `${distance} of ${across}`);
    const both = await marks(page);
    await drag(page, 40, 0, { from: await middle(page, 0, 100) });
    await refined(page);
    assert.ok(await marks(page) > 10 && both > 100, "the line turns with the volume");
    await page.locator("#unmeasure").click();
    assert.equal(await marks(page), 0);
    await page.locator("#picture").focus();
    await page.keyboard.press("Escape");
    assert.equal(await page.locator("#measure").getAttribute("aria-pressed"), "false");
  });

  on("legend, box and axes are drawn in the picture", async (page, first) => {
    await page.locator("#picture").focus();
    let before = first;
    for (const [key, id] of [["l", "#legend"], ["b", "#bounding-box"], ["x", "#axes"]]) {
      await page.keyboard.press(key);
      const now = await refined(page);
      assert.ok(difference(now, before) > 0.05, id);
      assert.ok(await page.locator(id).isChecked());
      before = now;
    }
    for (const key of ["l", "b", "x"]) await page.keyboard.press(key);
    isSame(await refined(page), first, "without them");
  });
});

describe("turning about points", () => {
  on("a double click chooses the pivot, which stays where it is", async (page) => {
    await load(page, OPAQUE);
    const at = await middle(page, -60, 40);
    await page.mouse.dblclick(...at);
    await page.locator("#problem", { hasText: "about this point" }).waitFor();
    assert.ok(await marks(page) > 10, "the pivot is marked");
    await page.mouse.move(...at);
    const before = (await reading(page)).match(/at ([-\d., ]+) \(/)[1].split(",").map(Number);
    await drag(page, 14, 6, { from: await middle(page, 60, 60) });
    await refined(page);
    await page.mouse.move(at[0] + 1, at[1]);
    await page.mouse.move(...at);
    const after = (await reading(page)).match(/at ([-\d., ]+) \(/)[1].split(",").map(Number);
    // Without a pivot this point would move by more than ten degrees about the centre.
    assert.ok(Math.hypot(...before.map((x, i) => x - after[i])) < 1.2, `${before} and ${after}`);
    const { camera } = await state(page);
    assert.ok(Math.hypot(...camera.center.map((x) => x - 15.5)) > 0.2, "the centre moved");
    await page.mouse.dblclick(15, 15);
    await page.locator("#problem", { hasText: "about the centre" }).waitFor();
    assert.equal(await marks(page), 0);
  });

  on("momentum is off, and can be switched on", async (page) => {
    const azimuths = async () => {
      await drag(page, 60, 0);
      const released = (await state(page)).camera.azimuth;
      await refined(page);
      return Math.abs((await state(page)).camera.azimuth - released);
    };
    assert.equal(await azimuths(), 0);
    await page.locator("#momentum").click();
    assert.ok(await azimuths() > 3, "it turns on");
  });

  on("corners of the cube", async (page) => {
    await page.keyboard.press("7");
    const corner = await refined(page);
    await page.keyboard.press("1");
    await refined(page);
    const box = await page.locator("#cube").boundingBox();
    // From the front, the upper right corner lies at 0.27 of the canvas from its middle.
    await page.mouse.click(box.x + box.width * 0.77, box.y + box.height * 0.23);
    isSame(await refined(page), corner, "the corner between front, right and above");
  });
});

describe("curve", () => {
  const points = async (page) => (await state(page)).transfer.opacities;

  on("tents by dragging on the histogram and by a click on the picture", async (page) => {
    await load(page, { colors: [[0, [1, 1, 1]]], opacities: [[0, 0], [250, 0]] });
    const dark = measured(await pixels(page)).mean[0];
    await page.locator("#tent").click();
    const box = await page.locator("#curve").boundingBox();
    await page.mouse.move(box.x + box.width * 0.4, box.y + box.height * 0.5);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.2, { steps: 4 });
    await page.mouse.up();
    const tent = await refined(page);
    assert.ok(measured(tent).mean[0] > dark + 2, "something is seen");
    const made = await points(page);
    assert.equal(made.length, 5, JSON.stringify(made));
    assert.ok(made[2][1] > 0.7 && Math.abs(made[2][0] - made[1][0] - (made[3][0] - made[2][0])) < 1e-6, JSON.stringify(made));
    // A click on the picture shows what has the value that is seen there, alone.
    await page.locator("#tent-alone").click();
    await answered(page, async () => page.mouse.click(...await middle(page, -30, 0)));
    isDifferent(await refined(page), tent, "around the value that was clicked");
    const alone = await points(page);
    assert.equal(alone.length, 3);
    assert.ok(alone[1][0] > made[1][0] - 10 && alone[1][0] < made[3][0] + 10, `${alone} around a value of ${made}`);
    // By keyboard, around the chosen point.
    await page.locator("#curve").focus();
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("Enter");
    assert.ok((await points(page)).some(([value, opacity]) => opacity === 0.5 && value > alone[1][0]));
  });

  on("several points are chosen, moved, flipped and deleted", async (page, first) => {
    await load(page, { colors: [[0, [1, 1, 1]]], opacities: [[0, 0], [60, 0.1], [90, 0.6], [160, 0.1], [250, 0]] });
    const before = await points(page);
    const box = await page.locator("#curve").boundingBox();
    const at = ([value, opacity]) => [box.x + 10 + (value / 250) * (box.width - 20), box.y + 9 + (1 - opacity) * (box.height - 18)];
    // A box around three of them; then one more, and not again.
    await page.keyboard.down("Shift");
    await page.mouse.move(at([40, 0.75])[0], at([40, 0.75])[1]);
    await page.mouse.down();
    await page.mouse.move(at([180, 0.04])[0], at([180, 0.04])[1], { steps: 4 });
    await page.mouse.up();
    await page.mouse.click(...at(before[0]));
    await page.mouse.click(...at(before[0]));
    await page.keyboard.up("Shift");
    await page.mouse.move(...at(before[2]));
    await page.mouse.down();
    await page.mouse.move(at(before[2])[0] + 20, at(before[2])[1], { steps: 4 });
    await page.mouse.up();
    const moved = await points(page);
    const ways = moved.map(([value], n) => value - before[n][0]);
    assert.ok(ways[0] === 0 && ways[4] === 0 && [1, 2, 3].every((n) => Math.abs(ways[n] - ways[2]) < 1e-9 && ways[n] > 5), `${ways}`);
    await page.locator("#flip").click();
    const mirrored = await points(page);
    assert.ok(Math.abs(mirrored[2][0] - (moved[1][0] + moved[3][0] - moved[2][0])) < 1e-9, JSON.stringify(mirrored));
    await page.locator("#curve").focus();
    await page.keyboard.press("Delete");
    assert.equal((await points(page)).length, 2);
    isDifferent(await refined(page), first, "deleted");
    await page.keyboard.press("Control+z");
    assert.equal((await points(page)).length, 5);
  });

  on("the range has handles, values and percentiles", async (page, first) => {
    const span = async () => {
      const { colors, opacities } = (await state(page)).transfer;
      const values = [...colors, ...opacities].map(([x]) => x);
      return [Math.min(...values), Math.max(...values)];
    };
    await set(page, "#range-high", 150);
    assert.ok(Math.abs((await span())[1] - 150) < 1);
    isDifferent(await refined(page), first, "a narrower range");
    await page.locator("#range-low-value").fill("20");
    await page.locator("#range-low-value").press("Tab");
    assert.equal((await span())[0], 20);
    await page.locator("#range-high-percentile").fill("99");
    await page.locator("#range-high-percentile").press("Tab");
    const [, high] = await span();
    assert.ok(high > 20 && high < 250 && (await page.locator("#range-high-percentile").inputValue()) === "99", `${high}`);
  });

  on("opacities on a logarithmic scale", async (page) => {
    await page.locator("#log-opacity").click();
    await page.locator("#curve").scrollIntoViewIfNeeded();
    const box = await page.locator("#curve").boundingBox();
    await page.mouse.click(box.x + box.width * 0.9, box.y + 9 + (box.height - 18) * (2 / 3));
    const opacities = (await points(page)).map(([, opacity]) => opacity);
    // A third of the height is a hundredth: the scale spans three decades.
    assert.ok(opacities.some((opacity) => Math.abs(opacity / 0.01 - 1) < 0.1), `${opacities}`);
  });

  on("the iso-value is dragged on the histogram", async (page) => {
    await section(page, "Look");
    await page.locator("#blend").selectOption("iso");
    const before = await refined(page);
    await page.locator("#curve").scrollIntoViewIfNeeded();
    const { iso } = (await state(page)).look;
    const box = await page.locator("#curve").boundingBox();
    const range = await page.locator("#range-low").evaluate(({ min, max }) => [Number(min), Number(max)]);
    const x = box.x + 10 + ((iso - range[0]) / (range[1] - range[0])) * (box.width - 20);
    await page.mouse.move(x, box.y + box.height * 0.35);
    await page.mouse.down();
    await page.mouse.move(x - 60, box.y + box.height * 0.35, { steps: 5 });
    await page.mouse.up();
    isDifferent(await refined(page), before, "another surface");
    assert.ok((await state(page)).look.iso < iso - 20);
  });
});

describe("light", () => {
  on("lights are added, chosen, dragged and deleted; gradients", async (page, first) => {
    await load(page, OPAQUE);
    const one = await pixels(page);
    await section(page, "Light");
    await page.locator("#add-light").click();
    const two = await refined(page);
    assert.ok(measured(two).mean[0] > measured(one).mean[0] + 1, "a second light");
    const box = await page.locator("#ball").boundingBox();
    // The headlight is in the middle of the ball: a press there chooses it, and a drag moves it.
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    assert.equal(await page.locator("#light").inputValue(), "0");
    await page.mouse.move(box.x + box.width * 0.15, box.y + box.height / 2, { steps: 4 });
    await page.mouse.up();
    assert.ok(difference(await refined(page), two) > 0.5, "the first light moved");
    const { lights } = (await state(page)).look;
    assert.ok(lights.length === 2 && lights[0].direction[0] < -0.5, JSON.stringify(lights));
    await page.locator("#shadows").click();
    const sharp = await refined(page);
    await set(page, "#angle", 40);
    assert.ok(difference(await refined(page), sharp) > 0.01, "soft shadows");
    await page.locator("#shadows").click();
    await page.locator("#delete-light").click();
    assert.equal((await state(page)).look.lights.length, 1);
    const white = await refined(page);
    await set(page, "#light-color", "#ff8000");
    const before = await refined(page);
    assert.ok(measured(before).mean[2] < measured(white).mean[2] - 1, "light without blue");
    assert.deepEqual((await state(page)).look.lights[0].color, [1, 0.502, 0]);
    await section(page, "Look");
    await page.locator("#gradient").selectOption("gaussian:1");
    assert.ok(difference(await refined(page), before) > 0.05, "gradients");
    void first;
  });
});

describe("studio", () => {
  on("the studio is chosen, keeps its light in the world while the camera turns, and gives the plain light back", async (page, first) => {
    const look = async () => (await state(page)).look;
    const before = await look();
    await page.locator("#lit").selectOption("studio");
    const studio = await refined(page);
    isDifferent(studio, first, "the studio");
    const { lights, studio: own, lights_follow } = await look();
    assert.ok(lights.length === 2 && !lights_follow && Math.abs(Math.hypot(...own.sky_up) - 1) < 1e-3, JSON.stringify(own));
    assert.ok(await page.locator("#shadows").isDisabled());
    await drag(page, 120, 40);
    const turned = await refined(page);
    assert.deepEqual((await look()).lights, lights);
    // The frames of a hand have light of lower resolution, but the same brightness.
    const mean = (picture) => measured(picture).mean.slice(0, 3).reduce((sum, value) => sum + value);
    await page.mouse.move(...await middle(page));
    await page.mouse.down();
    await page.mouse.move(...await middle(page, 1, 0));
    await page.waitForFunction(() => globalThis.layersplat.shown.step === "moving");
    const moving = await pixels(page);
    await page.mouse.up();
    assert.ok(Math.abs(mean(moving) / mean(await refined(page)) - 1) < 0.03, `${mean(moving)} of ${mean(turned)}`);
    await section(page, "Light");
    await set(page, "#exposure", 1);
    assert.ok(mean(await refined(page)) > 1.1 * mean(turned), "the exposure");
    await set(page, "#scattering", 0);
    assert.deepEqual((await look()).studio, { ...own, exposure: 1, scattering: 0 });
    await reload(page);
    await page.waitForFunction(() => globalThis.layersplat?.shown.pictures > 0);
    assert.equal((await look()).studio.exposure, 1);
    await page.locator("#lit").selectOption("plain");
    await refined(page);
    assert.deepEqual([(await look()).studio, (await look()).lights], [null, before.lights]);
  });
});

describe("settings", () => {
  /** Values other than the default, of all settings whose controls the program describes. @type {Record<string, string | number | boolean>} */
  const VALUES = { unit_distance: 4, extinction: "linear", early_termination: false, gamma: 2 };

  on("every described control changes the picture, and its default is as before", async (page, first) => {
    await section(page, "Look");
    const names = await page.locator("#plain [id]").evaluateAll((controls) => controls.map(({ id }) => id.replace("setting-", "")));
    assert.deepEqual(names, Object.keys(VALUES));
    for (const [name, value] of Object.entries(VALUES)) {
      const id = `#setting-${name}`;
      const defaultValue = await page.locator(id).inputValue();
      const put = async (/** @type {string | number | boolean} */ to) => {
        if (typeof value === "boolean") await page.locator(id).click();
        else if (typeof value === "string") await page.locator(id).selectOption(String(to));
        else await set(page, id, to);
      };
      await answered(page, () => put(value));
      assert.equal((await state(page)).look.plain[name], value);
      const least = name === "early_termination" ? -1 : SAME;
      assert.ok(difference(await refined(page), first) > least, name);
      await answered(page, () => put(defaultValue));
      assert.deepEqual((await state(page)).look.plain, {});
      isSame(await refined(page), first, name);
    }
  });
});

describe("cutting", () => {
  on("faces of the crop box are dragged in the picture", async (page) => {
    await page.keyboard.press("1");
    await answered(page, () => page.keyboard.press("f"));
    const front = await refined(page);
    await section(page, "Cutting");
    await page.locator("#handles").click();
    assert.ok(await marks(page) > 200);
    // From the front, x is to the right. The right face is half of 31 voxels from the middle.
    const { camera } = await state(page);
    const height = await page.locator("#picture").evaluate((canvas) => canvas.clientHeight);
    const perVoxel = height / 2 / camera.projection.parallel_scale;
    const at = await middle(page, (31 - camera.center[0]) * perVoxel, (camera.center[1] - 15.5) * perVoxel);
    await page.mouse.move(...at);
    await page.mouse.down();
    await page.mouse.move(at[0] - 12 * perVoxel, at[1], { steps: 5 });
    await page.mouse.up();
    const cut = await refined(page);
    assert.ok(Math.abs((await state(page)).look.crop[1][0] - 19) < 0.5, JSON.stringify((await state(page)).look.crop));
    assert.ok(measured(cut).x < measured(front).x - 0.02, "the right part is gone");
    assert.equal((await state(page)).camera.azimuth, camera.azimuth, "the volume was not turned");
  });

  on("clip planes are dragged and flipped in the picture", async (page) => {
    await page.keyboard.press("1");
    await answered(page, () => page.keyboard.press("f"));
    await section(page, "Cutting");
    await page.locator("#handles").click();
    await page.locator("#add-clip").click();
    // A plane that is seen from the side: its visible side is to the right.
    for (const [name, value] of [["x", "1"], ["z", "0"]]) {
      await page.getByLabel(`Plane 1, normal ${name}`).fill(value);
      await page.getByLabel(`Plane 1, normal ${name}`).press("Tab");
    }
    const half = await refined(page);
    const { camera, look } = await state(page);
    const height = await page.locator("#picture").evaluate((canvas) => canvas.clientHeight);
    const pixelsPerUnit = height / 2 / camera.projection.parallel_scale;
    const place = async (point) => middle(page, (point[0] - camera.center[0]) * pixelsPerUnit, (camera.center[1] - point[1]) * pixelsPerUnit);
    const at = await place(look.clips[0]);
    await page.mouse.move(...at);
    await page.mouse.down();
    await page.mouse.move(at[0] + 5 * pixelsPerUnit, at[1], { steps: 5 });
    await page.mouse.up();
    const moved = await refined(page);
    isDifferent(moved, half, "dragged");
    const [point, normal] = [(await state(page)).look.clips[0].slice(0, 3), (await state(page)).look.clips[0].slice(3)];
    assert.ok(Math.abs(point[0] - look.clips[0][0] - 5) < 0.3, `${point}`);
    await page.mouse.click(...await place(point.map((x, i) => x + normal[i] * 0.14 * Math.sqrt(3) * 31)));
    const flipped = await refined(page);
    isDifferent(flipped, moved, "flipped");
    assert.deepEqual((await state(page)).look.clips[0].slice(3), [-1, 0, 0]);
    assert.ok(measured(flipped).x < measured(moved).x - DIFFERENT / 10, "the left part is seen");
  });
});
