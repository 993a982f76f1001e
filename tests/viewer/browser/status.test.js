// What the page says of its picture: "refined" is said only of a picture of the present request, whatever was changed.

import assert from "node:assert/strict";
import { test } from "node:test";
import { pagesIn } from "./shared.js";
import { refined } from "./viewer.js";

const voxels = (count) => Buffer.from(Array.from({ length: count * 16 ** 3 }, (_, n) => (n % 16) * 17));
const header = (more) => `ObjectType = Image\nNDims = ${more.includes("16 16 16 2") ? 4 : 3}\n${more}ElementType = MET_UCHAR\nElementDataFile = LOCAL\n`;
const segment = (n) => `Segment${n}_ID:=s${n}\nSegment${n}_Name:=part ${n}\nSegment${n}_LabelValue:=${17 * (n + 1)}\nSegment${n}_Layer:=0\n`;
const labels = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 16\nencoding: raw\n${segment(0)}${segment(1)}\n`;
const on = pagesIn({
  "cube_16x16x16_uint8.raw": voxels(1),
  "channels.mha": Buffer.concat([Buffer.from(header("DimSize = 16 16 16\nElementNumberOfChannels = 2\n")), voxels(2)]),
  "steps.mha": Buffer.concat([Buffer.from(header("DimSize = 16 16 16 2\n")), voxels(2)]),
  "labels.seg.nrrd": Buffer.concat([Buffer.from(labels), voxels(1)]),
}, "--quality", "draft");

/** Changes a control of the panel, and returns at once, before any answer: the page's words, and whether a picture is awaited. */
const changed = (page, number) => page.evaluate((n) => {
  const control = document.querySelectorAll(globalThis.controls)[n];
  const name = control.id || control.getAttribute("aria-label") || control.textContent;
  const viewer = globalThis.layersplat;
  const before = viewer.requested();
  if (control instanceof HTMLButtonElement || control.type === "checkbox") control.click();
  else {
    if (control instanceof HTMLSelectElement) control.selectedIndex = (control.selectedIndex + 1) % control.options.length;
    else if (control.type === "color") control.value = control.value === "#336699" ? "#996633" : "#336699";
    else control.value = String(Number(control.value) * 0.9 + 0.01);
    for (const kind of ["input", "change"]) control.dispatchEvent(new Event(kind, { bubbles: true }));
  }
  return {
    name, asked: viewer.requested() > before, awaited: viewer.shown.id < viewer.requested(),
    text: document.getElementById("status").textContent, old: document.getElementById("stage").classList.contains("old"),
  };
}, number);

const KINDS = { "cube_16x16x16_uint8.raw": 60, "channels.mha": 40, "steps.mha": 60, "labels.seg.nrrd": 20 };
for (const [volume, least] of Object.entries(KINDS)) on(`no control leaves "refined" under an old picture: ${volume}`, async (page) => {
  await page.evaluate((name) => {
    globalThis.controls = ":is(#panel, #time, #slices) :is(input, select, button)";
    const offered = document.getElementById("offered");
    offered.value = name;
    offered.dispatchEvent(new Event("change"));
  }, volume);
  await page.waitForFunction((name) => document.getElementById("name").textContent === name, volume);
  await refined(page);
  // The quality of a fixed picture is its name.
  await page.evaluate(() => {
    globalThis.wrong = [];
    const { shown, requested } = globalThis.layersplat;
    const line = document.getElementById("status");
    new MutationObserver(() => {
      if (/refined|standard|high/.test(line.textContent) && shown.id < requested()) globalThis.wrong.push(line.textContent);
    }).observe(line, { childList: true, characterData: true, subtree: true });
    // Files and films are no pictures of the page.
    globalThis.skipped = /^(open-file|load-transfer|save|copy|copy-python|film-|offered|volume-|transfer-|help-button|upload)/;
  });
  const count = await page.evaluate(() => document.querySelectorAll(globalThis.controls).length);
  let asked = 0;
  for (let n = 0; n < count; n += 1) {
    const isSkipped = await page.evaluate((number) => {
      const control = document.querySelectorAll(globalThis.controls)[number];
      return Boolean(!control || control.disabled || control.closest("[hidden]") || globalThis.skipped.test(control.id) || control.type === "file");
    }, n);
    if (isSkipped) continue;
    const { name, asked: isAsked, awaited, text } = await changed(page, n);
    asked += Number(isAsked);
    assert.ok(!awaited || !/refined|standard|high/.test(text), `${name}: ${text}`);
  }
  assert.ok(asked > least, `${asked} controls asked for a picture`);
  assert.deepEqual(await page.evaluate(() => globalThis.wrong), []);
});

on("another kind of picture dims the last one until it is there", async (page) => {
  const wanted = await page.evaluate(() => {
    const blend = document.getElementById("blend");
    blend.value = "maximum";
    blend.dispatchEvent(new Event("change"));
    return [document.getElementById("stage").className, document.getElementById("status").textContent];
  });
  assert.match(wanted[0], /\bold\b/);
  assert.match(wanted[1], /drawing/);
  await refined(page);
  assert.doesNotMatch(await page.locator("#stage").getAttribute("class"), /\bold\b/);
});

on("a volume that is coming is named over the dimmed picture of the last one", async (page) => {
  const words = await page.evaluate(() => new Promise((done) => {
    const said = [];
    const [line, stage, name] = ["status", "stage", "name"].map((id) => document.getElementById(id));
    const note = () => {
      const { shown, requested } = globalThis.layersplat;
      said.push({ text: line.textContent, name: name.textContent, isDim: stage.classList.contains("coming"), isOld: shown.id < requested() });
      if (name.textContent.startsWith("cube") && !said.at(-1).isDim) done(said);
      else requestAnimationFrame(note);
    };
    const offered = document.getElementById("offered");
    offered.value = "cube_16x16x16_uint8.raw";
    offered.dispatchEvent(new Event("change"));
    note();
  }));
  assert.ok(words.slice(0, -1).every(({ isDim }) => isDim), JSON.stringify(words));
  assert.match(words[0].text, /opening cube_16x16x16_uint8\.raw/);
  assert.ok(words.every(({ text, name, isOld }) => !/refined/.test(text) || (name.startsWith("cube") && !isOld)), JSON.stringify(words));
  await refined(page);
});

on("what takes a while before a picture can be asked for is said, and so is the volume on its way after another problem", async (page) => {
  await page.evaluate(() => {
    const connection = globalThis.layersplat.connection();
    const send = connection.send.bind(connection);
    // The answers do not come.
    connection.send = (request) => { if (!["named", "open"].includes(request.type)) send(request); };
    document.getElementById("automatic").click();
  });
  await page.locator("#status", { hasText: "looking at the values" }).waitFor();
  await page.evaluate(() => {
    const offered = document.getElementById("offered");
    offered.value = "steps.mha";
    offered.dispatchEvent(new Event("change"));
    globalThis.layersplat.connection().send({ type: "fit", camera: globalThis.layersplat.state().camera, width: 0, height: 1 });
  });
  await page.locator("#problem", { hasText: "viewport" }).waitFor();
  assert.match(await page.locator("#status").textContent(), /opening steps\.mha/);
});

on("a change that is refused is taken back", async (page) => {
  await page.evaluate(() => {
    const quality = document.getElementById("quality");
    quality.value = "paper";
    quality.dispatchEvent(new Event("change"));
  });
  await refined(page);
  await page.evaluate(() => {
    const kernel = document.getElementById("kernel");
    kernel.disabled = false;
    kernel.value = "linear";
    kernel.dispatchEvent(new Event("change"));
  });
  await page.locator("#problem", { hasText: /cubic/ }).waitFor();
  assert.equal(await page.evaluate(() => globalThis.layersplat.state().look.kernel), null);
  await refined(page);
});

test("before the first picture the page says what it waits for", async () => {
  const page = await (await on.browser().newContext()).newPage();
  await page.addInitScript(() => {
    globalThis.said = [];
    const note = () => {
      const line = document.getElementById("status");
      if (line && globalThis.layersplat?.shown.pictures === 0) globalThis.said.push(line.textContent);
      requestAnimationFrame(note);
    };
    note();
  });
  await page.goto(on.server().url);
  await refined(page);
  const said = await page.evaluate(() => globalThis.said);
  assert.ok(said.length > 0 && said.every((text) => /(connecting|drawing|fitting the view|building programs|checking the device)/.test(text)), JSON.stringify(said));
  await page.context().close();
});
