// Measures the viewer; benches/viewer/run starts this beside the browser's tests, whose helpers it uses.

import net from "node:net";
import { launch, open, refined, serve } from "./viewer.js";

/** Milliseconds between moves of the mouse: 60 a second. */
const MOVE = 1000 / 60;
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

const sorted = (values) => [...values].sort((a, b) => a - b);
const quantile = (values, q) => sorted(values)[Math.min(values.length - 1, Math.floor(q * values.length))];
const wait = (ms) => new Promise((done) => { setTimeout(done, ms); });

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

async function inBrowser(url) {
  const browser = await launch();
  const context = await browser.newContext({ viewport: { width: 768, height: 768 } });
  await context.addInitScript(instrument);
  const page = await open({ newContext: () => context }, url);
  await page.waitForFunction(() => !document.getElementById("status").textContent.includes("preparing"));
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
  await drag(0);
  for (let n = 0; n < 60; n += 1) await drag(n);
  await measure(page, "turning with shadows, light fixed", drag);
  await page.mouse.up();
  await browser.close();
}

/** The server alone: asks for the next view as soon as a picture is there. */
async function alone(url) {
  const { host, hostname, port, searchParams } = new URL(url);
  const answer = await fetch(`http://${host}/?token=${searchParams.get("token")}`);
  const cookie = answer.headers.get("set-cookie").split(";")[0];
  const socket = net.connect(Number(port), hostname);
  socket.setNoDelay(true);
  socket.write(`GET /socket HTTP/1.1\r\nHost: ${host}\r\nOrigin: http://${host}\r\nCookie: ${cookie}\r\nConnection: Upgrade\r\n`
    + "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  let buffer = Buffer.alloc(0);
  let waiting = null;
  socket.on("data", (data) => {
    buffer = Buffer.concat([buffer, data]);
    waiting?.();
  });
  const more = () => new Promise((done) => { waiting = done; });
  while (!buffer.includes("\r\n\r\n")) await more();
  buffer = buffer.subarray(buffer.indexOf("\r\n\r\n") + 4);
  const receive = async () => {
    for (;;) {
      const short = buffer[1] & 127;
      const head = short === 126 ? 4 : short === 127 ? 10 : 2;
      if (buffer.length >= head) {
        const length = head === 2 ? short : head === 4 ? buffer.readUInt16BE(2) : Number(buffer.readBigUInt64BE(2));
        if (buffer.length >= head + length) {
          const message = { kind: buffer[0] & 15, payload: buffer.subarray(head, head + length) };
          buffer = buffer.subarray(head + length);
          return message;
        }
      }
      await more();
    }
  };
  const send = (request) => {
    const payload = Buffer.from(JSON.stringify(request));
    const head = payload.length < 126 ? [0x81, 0x80 | payload.length] : [0x81, 0xfe, payload.length >> 8, payload.length & 255];
    socket.write(Buffer.concat([Buffer.from([...head, 0, 0, 0, 0]), payload]));
  };
  const { camera } = JSON.parse((await receive()).payload);
  const times = [];
  const begin = performance.now();
  for (let id = 1; performance.now() - begin < seconds * 1000; id += 1) {
    const asked = performance.now();
    send({ type: "view", id, camera: { ...camera, azimuth: camera.azimuth + id }, width: 768, height: 768, moving: true });
    let message = await receive();
    while (message.kind !== 2) message = await receive();
    times.push(performance.now() - asked);
    send({ type: "shown" });
  }
  socket.destroy();
  console.log(`server alone, request to last byte: median ${quantile(times, 0.5).toFixed(0)} ms, 99 % ${quantile(times, 0.99).toFixed(0)} ms, ${times.length} pictures`);
}

const server = await serve(volume);
await inBrowser(server.url);
await alone(server.url);
await server.end();
