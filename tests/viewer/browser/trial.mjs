import { launch, open, refined, serveIn, pixels } from "./viewer.js";
import { readFileSync, mkdirSync, statSync, readdirSync } from "node:fs";
const D = "/work/t/pagex/"; mkdirSync(D + "fold/temporary", { recursive: true });
const s = await serveIn(D + "fold", "--quality", "standard");
const b = await launch();
const page = await open(b, s.url, { viewport: { width: 1100, height: 700 } });
const shot = (n) => page.screenshot({ path: D + n + ".png" });
const say = (...t) => console.log(new Date().toISOString().slice(11, 19), ...t);
const text = (id) => page.locator(id).textContent();
await shot("t0");
// raw dialog
await page.locator("#volume-file").setInputFiles({ name: "Köpf.raw", mimeType: "", buffer: Buffer.alloc(2 * 12 ** 3 + 64) });
await page.locator("#raw-dims").fill("12x12x12"); await page.locator("#raw-type").selectOption("uint16");
await page.waitForTimeout(200); await shot("t1"); say("raw", await text("#raw-size"));
await page.locator("#raw button", { hasText: "Cancel" }).click();
// SEG
const file = (p, name) => ({ name, mimeType: "", buffer: readFileSync(p) });
await page.locator("#volume-file").setInputFiles([file(D + "odd/seg_overlap.dcm", "Seg Köpf.dcm")]);
await page.waitForFunction(() => document.getElementById("name").textContent.startsWith("Seg"));
await refined(page); await page.waitForTimeout(400); await shot("t2"); say("seg", await text("#name"), await text("#facts"));
say("files", ...readdirSync(D + "fold/temporary").map((f) => f + " " + (statSync(D + "fold/temporary/" + f).mode & 0o777).toString(8) + " " + readdirSync(D + "fold/temporary/" + f).map((g) => g + " " + (statSync(D + "fold/temporary/" + f + "/" + g).mode & 0o777).toString(8)).join()));
// OME set
await page.locator("#volume-file").setInputFiles([file(D + "omeset/c0.ome.tif", "c0.ome.tif"), file(D + "omeset/c1.ome.tif", "c1.ome.tif")]);
await page.waitForFunction(() => document.getElementById("name").textContent.startsWith("c0"), null, { timeout: 60000 }).catch(async () => say("PROBLEM", await text("#problem")));
await refined(page); await page.waitForTimeout(400); await shot("t3"); say("ome", await text("#name"), await text("#facts"), await page.locator("#channels li").allTextContents());
// several SEG + ct dropped
await page.locator("#volume-file").setInputFiles([0, 1, 2, 3, 4, 5, 6, 7, 8].map((k) => file(D + `odd/ct/${k}.dcm`, `${k}.dcm`)));
await page.waitForFunction(() => document.getElementById("facts").textContent.includes("7 × 5 × 9"), null, { timeout: 60000 }).catch(async () => say("PROBLEM", await text("#problem")));
await refined(page); say("ct", await text("#name"), await text("#facts"));
// built-in
await page.locator("#offered").evaluate((e) => { e.value = "builtin:hydrogen"; e.dispatchEvent(new Event("change")); });
await page.waitForFunction(() => document.getElementById("name").textContent.includes("hydrogen")); await refined(page);
// squeezed picture: record aspect of the shown picture per animation frame while the window changes
await page.evaluate(() => {
  globalThis.ratios = [];
  const note = () => { const c = document.getElementById("picture"); const r = c.getBoundingClientRect(); globalThis.ratios.push([c.width / c.height / (r.width / r.height), getComputedStyle(c).objectFit]); requestAnimationFrame(note); };
  note();
});
await page.setViewportSize({ width: 700, height: 700 }); await page.waitForTimeout(1500); await refined(page); await shot("t4");
await page.keyboard.press("v"); await refined(page); await page.waitForTimeout(800); await shot("t5");
await page.setViewportSize({ width: 1100, height: 700 }); await refined(page); await page.waitForTimeout(800); await shot("t6");
say("ratios", JSON.stringify(await page.evaluate(() => [...new Set(globalThis.ratios.map(([q, f]) => q.toFixed(2) + " " + f))])));
await page.keyboard.press("v"); await refined(page);
// help list
await page.keyboard.press("?"); await page.waitForTimeout(300); await shot("t7"); say("help", JSON.stringify(await page.evaluate(() => { const d = document.getElementById("help"); return [d.scrollTop, document.activeElement.id]; }))); await page.keyboard.press("Escape");
// fields cut off: clientWidth < scrollWidth
await page.evaluate(() => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
await page.waitForTimeout(300);
say("cut", JSON.stringify(await page.evaluate(() => [...document.querySelectorAll("#panel :is(input[type=number], input:not([type]), button, select, label, summary, p)")].filter((e) => e.clientWidth > 0 && e.scrollWidth > e.clientWidth + 1).map((e) => [e.id || e.textContent.slice(0, 20), e.scrollWidth, e.clientWidth]))));
await page.evaluate(() => document.getElementById("crop")?.scrollIntoView()); await page.locator("#handles").click(); await refined(page); await page.waitForTimeout(300); await shot("t8");
// zoom bounded
const zoom = async (key, n) => { await page.locator("#picture").focus(); for (let i = 0; i < n; i += 1) await page.keyboard.press(key); await page.waitForTimeout(300); };
await zoom("-", 150); say("zoom out", JSON.stringify(await page.evaluate(() => globalThis.layersplat.state().camera))); await zoom("+", 400); say("zoom in", JSON.stringify(await page.evaluate(() => globalThis.layersplat.state().camera)));
await page.locator("#picture").focus(); await page.keyboard.press("f"); await refined(page);
say("reset titles", JSON.stringify(await page.evaluate(() => [...document.querySelectorAll("button")].filter((e) => /reset/i.test(e.textContent + e.id)).map((e) => [e.id, e.textContent, e.title]))));
say("errors", JSON.stringify([page.errors, page.foreign]));
await b.close(); await s.end();
