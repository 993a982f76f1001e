// Live views in JupyterLab and Notebook 7, as a user has them.

import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { command, drag, open, pixels, refined, run, serve } from "./jupyter.js";
import { difference, launch, measured } from "./viewer.js";

/** Mean difference of pictures that a user would call different, in 8-bit steps. */
const DIFFERENT = 0.8;
/** Of pictures of the same view, after rounding of angles. */
const SAME = 0.02;

const CELLS = [
  `import json, pathlib
import numpy as np
import layersplat
z, y, x = np.mgrid[-1:1:48j, -1:1:48j, -1:1:48j]
field = np.exp(-5 * ((x - 0.3)**2 + 3 * (y + 0.2)**2 + z**2)) + np.exp(-9 * ((x + 0.5)**2 + (y - 0.4)**2 + (z - 0.2)**2))
heard = []
def hear(change):
    heard.append(change.name)
    camera = view.camera and view.camera.position
    state = {"heard": heard, "camera": camera, "background": view.background, "opacities": view.transfer.opacities, "settings": repr(view.settings)}
    pathlib.Path("heard.json").write_text(json.dumps(state))
view = layersplat.volshow(field, cmap="fire", opacity="linear", size=(480, 360))
view.observe(hear)
view`,
  `other = layersplat.volshow(field, cmap="viridis", opacity="linear", size=(300, 300), azimuth=120)
other`,
];

const isDifferent = (a, b, what) => assert.ok(difference(a, b) > DIFFERENT, `${what}: ${difference(a, b)}`);
const isSame = (a, b, what) => assert.ok(difference(a, b) <= SAME, `${what}: ${difference(a, b)}`);

let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

for (const [kind, name] of [["lab", "JupyterLab"], ["notebook", "Notebook 7"]]) {
  describe(name, () => {
    let server;
    let page;
    /** What the kernel's handler was told. */
    const heard = async () => JSON.parse(await readFile(join(server.folder, "heard.json"), "utf8"));
    /** Waits until the handler was told something that fits. */
    const until = async (fits) => {
      for (;;) {
        const state = await heard().catch(() => null);
        if (state && fits(state)) return state;
        await page.waitForTimeout(50);
      }
    };
    const views = () => page.locator(".layersplat");
    const screenshot = (what) => page.screenshot({ path: join(process.env.SCREENSHOTS ?? ".", `${kind}-${what}.png`) });

    before(async () => {
      server = await serve(kind, CELLS);
      page = await open(browser, server.url);
      await command(page, "notebook:run-all-cells");
    });
    after(async () => {
      await page.context().close();
      await server.end();
    });

    test("a cell shows the picture of the view, and hides the still one", async () => {
      const shown = await refined(page);
      await screenshot("opened");
      assert.ok(measured(shown).mean.slice(0, 3).some((mean) => mean > 3));
      const box = await views().first().locator("#picture").boundingBox();
      assert.deepEqual([Math.round(box.width), Math.round(box.height)], [480, 360]);
      assert.equal(await page.locator("img[alt='The volume']:visible").count(), 0);
      assert.equal(await page.locator("img[alt='The volume']").count(), 2);
    });

    test("a drag changes the picture of its view alone, and view.camera follows", async () => {
      const [first, second] = [await refined(page, 0), await refined(page, 1)];
      isDifferent(first, second, "two views");
      await drag(page, 0, 120, 30);
      isDifferent(await refined(page, 0), first, "the dragged view");
      isSame(await refined(page, 1), second, "the other one");
      const state = await until(({ camera }) => camera);
      assert.ok(state.heard.every((changed) => changed === "camera"), state.heard.join());
    });

    test("what is set is shown: view.camera, angles, settings, transfer", async () => {
      const dragged = await refined(page);
      await run(page, "view.azimuth = 30");
      const taken = await refined(page);
      isDifferent(taken, dragged, "the angles take over");
      await until(({ camera }) => camera === null);
      await run(page, "camera = view._camera()\nview.camera = layersplat.Camera.orbit(camera.focal_point, 100, azimuth=200, scale=camera.scale)");
      isDifferent(await refined(page), taken, "a camera");
      await run(page, "view.settings = layersplat.Settings(blend='maximum')");
      const maximum = await refined(page);
      await run(page, "view.set_transfer('viridis', opacity='linear')");
      isDifferent(await refined(page), maximum, "a transfer function");
      await run(page, "view.settings, view.camera = layersplat.Settings(), None\nview.set_transfer('fire', opacity='linear')");
      isSame(await refined(page), taken, "and back again");
    });

    test("changes in the panel are those of the view", async () => {
      const before = await refined(page);
      const view = views().first();
      await view.locator("#fold").click();
      await view.locator("summary", { hasText: "Look" }).click();
      await view.locator("#background").evaluate((field) => {
        field.value = "#204060";
        field.dispatchEvent(new Event("change"));
      });
      await view.locator("#fade").evaluate((field) => {
        field.value = "-0.5";
        field.dispatchEvent(new Event("input"));
        field.dispatchEvent(new Event("change"));
      });
      await view.locator("#blend").selectOption("average");
      const state = await until(({ background, settings }) => background === "#204060" && settings.includes("average"));
      assert.ok(Math.max(...state.opacities.map(([, opacity]) => opacity)) < 0.6);
      isDifferent(await refined(page), before, "the picture");
      await screenshot("panel");
      await view.locator("#reset").click();
      isSame(await refined(page), before, "after resetting");
      await view.locator("#fold").click();
    });

    test("keys are the page's where it has the focus, and the notebook's elsewhere", async () => {
      const before = await refined(page);
      const count = await page.locator(".jp-Notebook .jp-Cell").count();
      await views().first().locator("#picture").focus();
      // In the notebook's command mode these would make a heading, add a cell and delete one.
      for (const key of ["3", "a", "d", "d"]) await page.keyboard.press(key);
      isDifferent(await refined(page), before, "the third side");
      assert.equal(await page.locator(".jp-Notebook .jp-Cell").count(), count);
      await page.keyboard.press("r");
      isSame(await refined(page), before, "the first view");
      assert.equal(await page.locator(".jp-MarkdownCell, .jp-RawCell").count(), 0);
    });

    test("the wheel scrolls until the picture is clicked", async () => {
      const picture = views().first().locator("#picture");
      await picture.evaluate((canvas) => canvas.blur());
      const before = await refined(page);
      const box = await picture.boundingBox();
      const at = [box.x + box.width / 2, box.y + box.height / 2];
      await page.mouse.move(...at);
      await page.mouse.wheel(0, -5);
      await page.waitForTimeout(400);
      isSame(await refined(page), before, "without the focus");
      await picture.focus();
      await page.mouse.wheel(0, -300);
      await page.waitForTimeout(400);
      isDifferent(await refined(page), before, "with the focus");
      await page.keyboard.press("r");
      await refined(page);
    });

    test("a kernel that does not hear draws afterwards, and the page says so", async () => {
      const before = await refined(page);
      const busy = views().first().locator("#busy");
      // It keeps the interpreter lock: kernels that hear while a cell runs, on a thread of their own, do not either.
      await run(page, "sum(range(5 * 10**8))", { waits: false });
      await drag(page, 0, 90, 0);
      await busy.waitFor({ state: "visible" });
      await screenshot("busy");
      await busy.waitFor({ state: "hidden" });
      isDifferent(await refined(page), before, "after the cell");
    });

    test("a saved notebook shows the still pictures", async () => {
      await command(page, "docmanager:save");
      const saved = await server.saved();
      const stills = saved.cells.flatMap(({ outputs }) => outputs).map(({ data }) => data["text/html"]).filter(Boolean);
      assert.equal(stills.length, 2);
      // Another server has no kernel of it.
      const reader = await serve(kind, CELLS);
      await writeFile(join(reader.folder, "view.ipynb"), JSON.stringify(saved));
      const other = await open(browser, reader.url);
      try {
        await other.locator("img[alt='The volume']").first().waitFor({ state: "visible" });
        assert.equal(await other.locator("img[alt='The volume']:visible").count(), 2);
        await other.screenshot({ path: join(process.env.SCREENSHOTS ?? ".", `${kind}-saved.png`) });
      } finally {
        await other.context().close();
        await reader.end();
      }
    });

    test("a closed view frees its page, and can be shown again", async () => {
      await run(page, "view.close()");
      await page.waitForFunction(() => document.querySelectorAll(".layersplat").length === 1);
      await command(page, "notebook:run-all-cells");
      await page.waitForFunction(() => document.querySelectorAll(".layersplat").length === 2);
      assert.ok(measured(await refined(page)).mean.slice(0, 3).some((mean) => mean > 3));
      assert.ok((await pixels(page, 1)).data.some((value) => value > 0));
    });
  });
}
