// How long a hand waits for the device while it is busy: with a refinement in `high`, with accumulation, with a saved picture and with a film.
//
// The wait is the time from a moving view to the begin of its frame on the server, and the way of the messages. Frames themselves take longer
// near 45 degrees, where two layer axes share the picture.

import { serve } from "../viewer.js";
import { quantile, wait } from "./numbers.js";
import { connect } from "./wire.js";

const [volume, count] = [process.argv[2], Number(process.argv[3])];
const SIDE = 768;
/** Moving views in a row of each hand. */
const MOVES = 6;

const server = await serve(volume);
const page = await connect(server.url);
let id = 0;

/** Milliseconds that the first of several moving views waits before its frame begins. */
async function hand() {
  let first = null;
  for (let n = 0; n < MOVES; n += 1) {
    id += 1;
    const asked = performance.now();
    page.view(id, id * 3, true, SIDE);
    const { milliseconds } = await page.shown(id, [0]);
    first ??= performance.now() - asked - milliseconds;
  }
  return first;
}

console.log("busy with | hands | wait median ms | wait 99 % ms | longest ms\n--- | --- | --- | --- | ---");

async function measure(name, work) {
  const waits = [];
  for (let n = 0; n < count; n += 1) {
    await work(n);
    waits.push(await hand());
  }
  const [median, most, longest] = [0.5, 0.99, 1].map((q) => quantile(waits, q).toFixed(1));
  console.log(`${name} | ${count} | ${median} | ${most} | ${longest}`);
}

/** Rests at a view, so that it is refined, and moves again in the middle. */
async function rest(step, longest) {
  id += 1;
  page.view(id, id * 3, false, SIDE);
  if (step !== null) await page.shown(id, [step]);
  await wait(longest * Math.random());
}
// Programs are loaded, and sizes chosen, before anything is measured.
for (let n = 0; n < 40; n += 1) await hand();
await rest(4, 0);
await measure("nothing", () => wait(30 + 170 * Math.random()));
await measure("standard", () => rest(null, 60));
await measure("high", () => rest(1, 250));
await measure("4 × 4 samples", async () => { await rest(2, 0); await wait(650 + 500 * Math.random()); });
const camera = (degrees) => ({ ...page.hello.camera, azimuth: page.hello.camera.azimuth + degrees });
page.send({ type: "save", camera: camera(0), width: 2048, height: 2048, samples: 4 });
await measure("a saved picture of 2048² with 4 × 4 samples", () => wait(400 + 400 * Math.random()));
const keys = [{ time: 0, camera: camera(0) }, { time: 20, camera: camera(360) }];
page.send({ type: "film", id: 1, keys, width: 1024, height: 1024, samples: 2, rate: 50, format: "gif" });
await measure("a film of 1024² with 2 × 2 samples", () => wait(400 + 400 * Math.random()));
page.close();
await server.end();
