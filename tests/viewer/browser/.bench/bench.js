// Measures the viewer; benches/viewer/run starts this beside the browser's tests, whose helpers it uses.

import { launch, open, refined, serve } from "../viewer.js";
import { quantile, wait } from "./numbers.js";
import { connect } from "./wire.js";

/** Milliseconds between moves of the mouse: 60 a second. */
const MOVE = 1000 / 60;
/** Pictures at rest. */
const RESTS = 15;
const [volume, seconds] = [process.argv[2], Number(process.argv[3])];

/** In the page: times of input events, and of the second animation frame after their picture. */
function instrument() {
  const bench = { input: 0, asked: new Map(), frames: [] };
  globalThis.bench = bench;
  for (const kind of ["pointermove", "wheel", "input"]) addEventListener(kind, (event) => { bench.input = event.timeStamp; }, true);
  const { send } = WebSocket.prototype;
  WebSocket.prototype.send = function (text) {
    const id = text.startsWith('{"type":"view"') && JSON.parse(text).id;
    if (id) bench.asked.set(id, bench.input);
    return send.call(this, text);
  };
  const { drawImage } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.drawImage = function (bitmap, ...rest) {
    const size = [bitmap.width, bitmap.height];
    const result = drawImage.call(this, bitmap, ...rest);
    if (this.canvas.id === "picture") {
      setTimeout(() => {
        const { id, step } = globalThis.layersplat.shown;
        requestAnimationFrame(() => requestAnimationFrame(() => {
          const now = performance.now();
          bench.frames.push({ step, size, at: now, latency: now - bench.asked.get(id) });
        }));
      });
    }
    return result;
  };
}

/** Moves for some seconds, and reports the pictures of that time. */
async function measure(page, name, move) {
  await page.evaluate(() => { globalThis.bench.frames = []; });
  const bytes = await page.evaluate(() => globalThis.layersplat.connection().bytes);
  const begin = performance.now();
  for (let n = 0; performance.now() - begin < seconds * 1000; n += 1) {
    await move(n);
    await wait(Math.max(0, begin + (n + 1) * MOVE - performance.now()));
  }
  const [frames, after] = await page.evaluate(() => [globalThis.bench.frames, globalThis.layersplat.connection().bytes]);
  const moving = frames.filter(({ step }) => step === "moving");
  const gaps = moving.slice(1).map(({ at }, n) => at - moving[n].at);
  const side = (i) => quantile(moving.map(({ size }) => size[i]), 0.5);
  const latency = moving.map((frame) => frame.latency);
  console.log([
    name, (moving.length / seconds).toFixed(1), quantile(latency, 0.5).toFixed(0), quantile(latency, 0.99).toFixed(0),
    Math.max(...gaps).toFixed(0), `${side(0)} × ${side(1)}`, ((after - bytes) / frames.length / 1000).toFixed(0),
  ].join(" | "));
}

/** Waits until the page says that programs are ready. */
const prepared = (page) =>
  page.waitForFunction(() => !document.getElementById("status").textContent.includes("preparing"), null, { timeout: 600_000 });

async function inBrowser(url) {
  const browser = await launch();
  const context = await browser.newContext({ viewport: { width: 768, height: 768 } });
  await context.addInitScript(instrument);
  const page = await open({ newContext: () => context }, url);
  await prepared(page);
  await page.keyboard.press("p");
  await refined(page);
  console.log("part | frames/s | median ms | 99 % ms | longest gap ms | drawn | kB per picture\n--- | --- | --- | --- | --- | --- | ---");
  const drag = async (n) => {
    if (n === 0) {
      await page.mouse.move(384, 384);
      await page.mouse.down();
    }
    await page.mouse.move(384 + 200 * Math.sin(n / 40), 384 + 120 * Math.sin(n / 67));
  };
  await measure(page, "turning", drag);
  await measure(page, "turning, quality changed every second", async (n) => {
    await drag(n + 1);
    if (n % 60 === 30) await page.evaluate((index) => {
      const quality = document.getElementById("quality");
      quality.selectedIndex = index;
      quality.dispatchEvent(new Event("change", { bubbles: true }));
    }, Math.floor(n / 60) % 5);
  });
  await page.evaluate(() => {
    const quality = document.getElementById("quality");
    quality.selectedIndex = 0;
    quality.dispatchEvent(new Event("change", { bubbles: true }));
  });
  await page.mouse.up();
  await refined(page);
  await measure(page, "zooming", (n) => page.mouse.wheel(0, n % 120 < 60 ? -20 : 20));
  const rest = performance.now();
  await refined(page);
  console.log(`refined ${(performance.now() - rest).toFixed(0)} ms after the last turn of the wheel`);
  await page.keyboard.press("p");
  await refined(page);
  const box = await page.locator("#curve").boundingBox();
  await measure(page, "curve, beside the panel", async (n) => {
    if (n === 0) {
      await page.mouse.move(box.x + box.width / 2, box.y + 100);
      await page.mouse.down();
    }
    await page.mouse.move(box.x + box.width / 2 + 20 * Math.sin(n / 20), box.y + 90 + 40 * Math.sin(n / 13));
  });
  await page.mouse.up();
  await page.evaluate(() => { document.querySelectorAll("details").forEach((part) => { part.open = true; }); });
  await page.locator("#shadows").click();
  await page.locator("#lights-follow").click();
  await page.locator("#picture").focus();
  await page.keyboard.press("p");
  await refined(page);
  await prepared(page);
  await drag(0);
  for (let n = 0; n < 60; n += 1) await drag(n);
  await measure(page, "turning with shadows, light fixed", drag);
  await page.mouse.up();
  await browser.close();
}

/** The server alone: asks for the next view as soon as a picture is there. */
async function alone(url) {
  const page = await connect(url);
  const times = [];
  const begin = performance.now();
  for (let id = 1; performance.now() - begin < seconds * 1000; id += 1) {
    const asked = performance.now();
    page.view(id, id, true);
    await page.picture();
    times.push(performance.now() - asked);
    page.send({ type: "shown" });
  }
  console.log(`server alone, request to last byte: median ${quantile(times, 0.5).toFixed(0)} ms, 99 % ${quantile(times, 0.99).toFixed(0)} ms, ${times.length} pictures`);
  // At rest: times from the request to the last byte of each step.
  const steps = new Map();
  for (let n = 0; n < RESTS; n += 1) {
    const [id, asked] = [1_000_000 + n, performance.now()];
    page.view(id, 17 * n, false);
    for (let step = 0; step !== 4;) {
      ({ step } = await page.picture());
      page.send({ type: "shown" });
      steps.set(step, [...steps.get(step) ?? [], performance.now() - asked]);
    }
  }
  const names = { 1: "standard", 2: "high", 3: "8 samples", 4: "16 samples" };
  const said = [...steps].map(([step, all]) => `${names[step]} ${quantile(all, 0.5).toFixed(0)} ms (most ${Math.max(...all).toFixed(0)})`);
  console.log(`at rest, from the request to the last byte, median of ${RESTS}: ${said.join(", ")}`);
  page.close();
}

const server = await serve(volume);
await inBrowser(server.url);
await alone(server.url);
await server.end();
