// The same hand on this viewer and on PyVista's remote rendering by trame (remote.py), in the same browser, one after the other.
//
// A picture counts when the browser has it: an image that was loaded or drawn to a canvas. Frames per second are measured in a drag with 60
// moves a second. Latency is measured by short movements, each long after the last, from the first event's time to the second animation
// frame after the first picture. A movement has several events because trame does not answer a single one.

import { spawn } from "node:child_process";
import net from "node:net";
import { launch, serve } from "../viewer.js";
import { quantile, wait } from "./numbers.js";
import { connect } from "./wire.js";

const [volume, seconds] = [process.argv[2], Number(process.argv[3])];
const SIZE = 768;
const MOVE = 1000 / 60;
const MOVEMENTS = 40;
/** Events of a movement. */
const EVENTS = 4;
const PYTHON = new URL("../../../../target/trame/bin/python", import.meta.url).pathname;
const SCRIPT = new URL("../../../../benches/viewer/remote.py", import.meta.url).pathname;

/** In the page: when pictures were shown, and how large they were. */
function instrument() {
  const bench = { input: null, pictures: [] };
  globalThis.bench = bench;
  for (const kind of ["pointermove", "mousemove"]) addEventListener(kind, (event) => { bench.input ??= event.timeStamp; }, true);
  const shown = (width, height) => {
    const { input } = bench;
    requestAnimationFrame(() => requestAnimationFrame(() => {
      const at = performance.now();
      bench.pictures.push({ at, latency: at - input, width, height });
    }));
  };
  const { drawImage } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.drawImage = function (image, ...rest) {
    const size = [image.width, image.height];
    const result = drawImage.call(this, image, ...rest);
    // The viewer's own pictures; its cube and curves are no pictures.
    if (this.canvas.id === "picture") shown(...size);
    return result;
  };
  const source = Object.getOwnPropertyDescriptor(HTMLImageElement.prototype, "src");
  Object.defineProperty(HTMLImageElement.prototype, "src", {
    ...source,
    set(value) {
      if (/^(blob|data):/.test(value)) this.addEventListener("load", () => shown(this.naturalWidth, this.naturalHeight), { once: true });
      source.set.call(this, value);
    },
  });
}

async function measure(page, name) {
  const place = (n) => [SIZE / 2 + 200 * Math.sin(n / 40), SIZE / 2 + 120 * Math.sin(n / 67)];
  const pictures = async () => page.evaluate(() => globalThis.bench.pictures.splice(0));
  await page.mouse.move(SIZE / 2, SIZE / 2);
  await page.mouse.down();
  for (let n = 0; n < 60; n += 1) { await page.mouse.move(...place(n)); await wait(MOVE); }
  await pictures();
  const begin = performance.now();
  for (let n = 60; performance.now() - begin < seconds * 1000; n += 1) {
    await page.mouse.move(...place(n));
    await wait(Math.max(0, begin + (n - 59) * MOVE - performance.now()));
  }
  const dragged = await pictures();
  const gaps = dragged.slice(1).map(({ at }, n) => at - dragged[n].at);
  const latencies = [];
  for (let n = 0; n < MOVEMENTS; n += 1) {
    await wait(900);
    await pictures();
    await page.evaluate(() => { globalThis.bench.input = null; });
    for (let event = 0; event < EVENTS; event += 1) {
      await page.mouse.move(SIZE / 2 + (n % 2 ? 8 : -8) * event, SIZE / 2 + n);
      await wait(MOVE);
    }
    await wait(1000);
    const [first] = await pictures();
    if (first) latencies.push(first.latency);
  }
  await page.mouse.up();
  const side = (field) => quantile(dragged.map((picture) => picture[field]), 0.5);
  console.log([
    name, (dragged.length / seconds).toFixed(1), gaps.length ? Math.max(...gaps).toFixed(0) : "–", quantile(latencies, 0.5)?.toFixed(0),
    quantile(latencies, 0.99)?.toFixed(0), `${latencies.length} of ${MOVEMENTS}`, `${side("width")} × ${side("height")}`,
  ].join(" | "));
}

async function open(browser, url) {
  const context = await browser.newContext({ viewport: { width: SIZE, height: SIZE } });
  await context.addInitScript(instrument);
  const page = await context.newPage();
  await page.goto(url);
  return page;
}

console.log("viewer | frames/s | longest gap ms | first picture of a movement, median ms | 99 % ms | answered | picture\n--- | --- | --- | --- | --- | --- | ---");
const browser = await launch();
const server = await serve(volume);
const { hello } = await connect(server.url).then((page) => { page.close(); return page; });
{
  const page = await open(browser, server.url);
  await page.waitForFunction(() => globalThis.layersplat?.shown.step === "refined", null, { timeout: 180_000 });
  await page.waitForFunction(() => !document.getElementById("status").textContent.includes("preparing"), null, { timeout: 180_000 });
  await page.keyboard.press("p");
  await wait(1000);
  await measure(page, "layersplat view");
  await page.screenshot({ path: "/tmp/layersplat-view.png" });
  await page.context().close();
}
await server.end();

const freePort = () => new Promise((done) => {
  const probe = net.createServer().listen(0, "127.0.0.1", () => { const { port } = probe.address(); probe.close(() => done(port)); });
});
for (const mapper of ["fixed_point", "gpu"]) {
  const port = await freePort();
  const remote = spawn(PYTHON, [SCRIPT, volume, String(port), mapper, String(SIZE)], { stdio: ["pipe", "pipe", "inherit"] });
  remote.stdin.end(JSON.stringify({ ...hello.transfer, dims: hello.volume.dims }));
  const ended = new Promise((done) => { remote.once("exit", done); });
  const [renderer] = await Promise.race([new Promise((done) => { remote.stdout.once("data", (data) => done([data.toString().trim()])); }), ended.then(() => ["ended"])]);
  console.error(renderer);
  for (let n = 0; n < 200; n += 1) {
    if (await fetch(`http://127.0.0.1:${port}/`).then(() => true, () => false)) break;
    await wait(300);
  }
  const page = await open(browser, `http://127.0.0.1:${port}/`);
  await page.waitForFunction(() => globalThis.bench.pictures.length > 0, null, { timeout: 120_000 }).catch(() => console.error("no picture"));
  await wait(3000);
  await measure(page, `trame, ${mapper}`);
  await page.screenshot({ path: `/tmp/trame-${mapper}.png` });
  await page.context().close();
  remote.kill("SIGINT");
  await Promise.race([ended, wait(5000).then(() => remote.kill("SIGKILL"))]);
}
await browser.close();
