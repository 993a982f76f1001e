// Resident memory of the server in mixed use: pages that turn with shadows, rest, show slices, change curves, open volumes, save pictures and
// films, and come and go. The same for some minutes, in rounds of the same work.

import { readFileSync } from "node:fs";
import { serve } from "../viewer.js";
import { quantile } from "./numbers.js";
import { connect } from "./wire.js";

const minutes = Number(process.argv[2]);
/** Size of the pictures of pages at rest, and of those that turn. */
const [REST, TURN] = [1200, 512];
/** Views of each turn. */
const VIEWS = 40;
/** Steps of saved pictures and of parts of films, which pages do not acknowledge. */
const [SAVED, PART] = [5, 7];

// Without a file it offers others.
const server = await serve("--azimuth", "30");
const resident = () => Number(/VmRSS:\s+(\d+) kB/.exec(readFileSync(`/proc/${server.process.pid}/status`, "utf8"))[1]) / 1024;
const peak = () => Number(/VmHWM:\s+(\d+) kB/.exec(readFileSync(`/proc/${server.process.pid}/status`, "utf8"))[1]) / 1024;
let id = 0;

/** Reads messages until one is wanted; acknowledges pictures. */
async function until(page, isWanted) {
  for (;;) {
    const { kind, payload } = await page.receive();
    if (kind === 2 && ![SAVED, PART].includes(payload[0])) page.send({ type: "shown" });
    const message = kind === 2 ? { type: "picture", step: payload[0], id: payload.readUInt32LE(4) } : kind === 1 ? JSON.parse(payload) : {};
    if (message.type === "problem") throw new Error(message.sentence);
    if (isWanted(message)) return message;
  }
}

/** Rests at a view until it is refined, at most to pictures of `step`. */
async function rest(page, degrees, step = 4, side = REST) {
  id += 1;
  const own = id;
  page.view(own, degrees, false, side);
  await until(page, (m) => (m.type === "picture" && m.id === own && m.step >= step && m.step < SAVED) || (m.type === "refined" && m.id === own));
}

async function turn(page, from, look = {}) {
  page.send({ type: "look", look: { ...page.hello.look, ...look } });
  for (let n = 0; n < VIEWS; n += 1) {
    id += 1;
    const own = id;
    page.view(own, from + 9 * n, true, TURN);
    await until(page, (m) => m.type === "picture" && m.id === own);
  }
}

async function slices(page) {
  const planes = page.hello.slices.axes.map(({ right, up }) => ({ right, up }));
  for (let n = 0; n < VIEWS; n += 1) {
    id += 1;
    const own = id;
    const point = page.hello.volume.centre.map((x) => x + n / 10);
    page.send({ type: "slices", id: own, point, planes, width: 300, height: 300, kernel: "cubic", window: [100, 150], thickness: null, moving: true });
    await until(page, (m) => m.type === "picture" && m.id === own);
  }
}

async function curves(page) {
  const { camera, palettes, presets } = page.hello;
  for (const [kind, { name }] of [["automatic", palettes[0]], ["preset", presets[0]]]) {
    page.send({ type: "named", field: 0, kind, name });
    const { colors, opacities } = await until(page, ({ type }) => type === "transfer");
    page.send({ type: "transfer", field: 0, colors, opacities });
    await rest(page, 20, 2);
    page.send({ type: "fit", camera, width: REST, height: REST });
    await until(page, ({ type }) => type === "fitted");
    page.send({ type: "pick", id, camera, height: REST, x: 0, y: 0 });
    await until(page, ({ type }) => type === "picked");
  }
}

async function keep(page) {
  const camera = (degrees) => ({ ...page.hello.camera, azimuth: page.hello.camera.azimuth + degrees });
  page.send({ type: "save", camera: camera(0), width: REST, height: REST, samples: 2 });
  await until(page, (m) => m.type === "picture" && m.step === SAVED);
  id += 1;
  page.send({ type: "film", id, keys: [{ time: 0, camera: camera(0) }, { time: 1, camera: camera(90) }], width: 256, height: 256, samples: 1, rate: 10, format: "gif" });
  await until(page, ({ type, state }) => type === "film" && state === "complete");
}

async function open(page, name) {
  page.send({ type: "open", volume: { offered: name } });
  page.hello = await until(page, ({ type }) => type === "hello");
}

const stays = [await connect(server.url), await connect(server.url)];
const known = stays[0].hello.offered.map(({ name }) => name);
const names = ["builtin:torus-knot", "builtin:hydrogen"].filter((name) => known.includes(name));
console.log("minutes | rounds | RSS MB | peak MB\n--- | --- | --- | ---");
const [begun, found] = [performance.now(), []];
for (let round = 0; performance.now() - begun < minutes * 60_000 || found.length < 4; round += 1) {
  const come = await Promise.all([connect(server.url), connect(server.url), connect(server.url)]);
  await Promise.all([
    turn(stays[0], 37 * round, { shadows: true }),
    rest(stays[1], 23 * round),
    slices(come[0]).then(() => curves(come[0])),
    keep(come[1]),
    open(come[2], names[round % names.length]).then(() => rest(come[2], 10)),
  ]);
  for (const page of come) page.close();
  await new Promise((done) => { setTimeout(done, 1000); });
  found.push(resident());
  console.log([((performance.now() - begun) / 60_000).toFixed(1), round + 1, found.at(-1).toFixed(1), peak().toFixed(1)].join(" | "));
}
// The first rounds build programs.
const part = Math.max(1, Math.floor(found.length / 4));
const [early, late] = [found.slice(part, 2 * part), found.slice(-part)].map((some) => quantile(some, 0.5));
console.log(`median of the second quarter ${early.toFixed(1)} MB, of the last ${late.toFixed(1)} MB: ${((late / early - 1) * 100).toFixed(1)} %, to be within 5 %: ${Math.abs(late / early - 1) <= 0.05 ? "yes" : "NO"}`);
for (const page of stays) page.close();
await server.end();
