import { launch, open, refined, serve } from "./viewer.js";
const s = await serve("builtin:hydrogen@64");
const b = await launch();
const once = async (deviceScaleFactor, width, height) => {
  const page = await open(b, s.url, { viewport: { width, height }, deviceScaleFactor });
  const times = [];
  for (let n = 0; n < 2; n += 1) {
    const t = performance.now();
    const before = await page.evaluate(() => globalThis.layersplat.requested());
    await page.locator("#picture").focus(); await page.keyboard.press(n % 2 ? "1" : "7");
    await page.waitForFunction((id) => globalThis.layersplat.requested() > id, before);
    await refined(page); times.push(Math.round(performance.now() - t));
  }
  const size = await page.evaluate(() => [document.getElementById("picture").width, document.getElementById("picture").height, globalThis.layersplat.shown.step]);
  await page.context().close();
  return [...size, ...times];
};
await once(1, 900, 600);
for (let n = 0; n < 2; n += 1) for (const r of [1, 2]) console.log(r, (await once(r, 900, 600)).join(" "), "load", (await import("node:os")).loadavg()[0].toFixed(1));
for (const r of [1, 2]) console.log("large", r, (await once(r, 1400, 900)).join(" "), "load", (await import("node:os")).loadavg()[0].toFixed(1));
await b.close(); await s.end();
