// Resident memory of the server: after the first frames and pages, and after ten times as many.

import { readFileSync } from "node:fs";
import { serve } from "../viewer.js";
import { quantile } from "./numbers.js";
import { connect } from "./wire.js";

const volume = process.argv[2];
const FRAMES = 10_000;
const PAGES = 50;
/** Size of the pictures, and how often the hand rests, with a refined picture up to `high`. */
const SIDE = 384;
const REST_EVERY = 50;

const server = await serve(volume, "--azimuth", "30");
const resident = () => Number(/VmRSS:\s+(\d+) kB/.exec(readFileSync(`/proc/${server.process.pid}/status`, "utf8"))[1]) / 1024;

const times = [];
let id = 0;
/** Draws frames on new pages in turn. */
async function draw(frames, pages) {
  for (let page = 0; page < pages; page += 1) {
    const connection = await connect(server.url);
    for (let n = 0; n < frames / pages; n += 1) {
      id += 1;
      const moving = id % REST_EVERY !== 0;
      const asked = performance.now();
      connection.view(id, id * 7, moving, SIDE);
      await connection.shown(id, moving ? [0] : [2, 3, 4]);
      if (moving) times.push(performance.now() - asked);
    }
    connection.close();
  }
}

console.log("frames | pages | RSS MB\n--- | --- | ---");
await draw(FRAMES / 10, PAGES / 10);
const first = resident();
console.log(`${id} | ${PAGES / 10} | ${first.toFixed(1)}`);
for (let part = 1; part <= 3; part += 1) {
  await draw(FRAMES * 0.3, PAGES * 0.3);
  console.log(`${id} | ${PAGES / 10 + part * PAGES * 0.3} | ${resident().toFixed(1)}`);
}
const ratio = resident() / first;
console.log(`ratio ${ratio.toFixed(3)}, to be within 5 %: ${Math.abs(ratio - 1) <= 0.05 ? "yes" : "NO"}; median frame ${quantile(times, 0.5).toFixed(0)} ms`);
await server.end();
