// The page: one state, shown by all parts and sent to the server.

import { axes, dot, otherProjection, panned, rolled, sum, times, toWorld, turned, unit, zoomed } from "./camera.js";
import { Connection } from "./connection.js";
import * as controls from "./controls.js";
import { Cutting } from "./cutting.js";
import { Editor } from "./editor.js";
import { Film } from "./film.js";
import { Files } from "./files.js";
import * as gestures from "./gestures.js";
import * as keys from "./keys.js";
import { Lighting } from "./lighting.js";
import { Picture } from "./picture.js";
import { Sides } from "./sides.js";
import { download, toClipboard } from "./saving.js";
import { copy, fromFragment, History, isEqual, toFragment } from "./state.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Look} Look */

/** Radians and half heights per press of a key. */
const KEY_TURN = (5 * Math.PI) / 180;
const KEY_PAN = 0.05;
const KEY_ZOOM = 1.1;
/** Milliseconds after the last key at which the hand rests. */
const KEY_REST = 250;
/** Milliseconds that a problem is shown for. */
const PROBLEM_TIME = 8000;
/** Milliseconds between changes of the address: browsers limit them. */
const ADDRESS_TIME = 300;

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));
const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (element(id));

const picture = new Picture(/** @type {HTMLCanvasElement} */ (element("picture")));
/** What the server said first. @type {any} */
let hello = null;
/** @type {History | null} */
let history = null;
/** The look and transfer function that the server has. */
let sent = { look: /** @type {Look | null} */ (null), transfer: /** @type {unknown} */ (null) };
let id = 0;
/** The last view of which no better picture comes. */
let refinedId = -1;
let isReady = false;
let isMoving = false;
let rest = 0;
/** Whether the next fitted camera is the first view. */
let awaits = /** @type {"nothing" | "first" | "fit"} */ ("nothing");
/** What the next command is for. */
let wantsCommand = false;
/** When the last pictures came. @type {number[]} */
let times30 = [];

/** For tests: what was shown last. */
const shown = { id: -1, step: "", pictures: 0 };
Object.assign(globalThis, { layersplat: { shown, requested: () => id, state: () => history?.now, connection: () => connection } });

const editor = new Editor({
  changed: (transfer) => { state().transfer = transfer; show({ exceptEditor: true }); move(); },
  rest: () => settle(),
});
const lighting = new Lighting({
  change: changeLook,
  toCamera: (world) => {
    const own = axes(state().camera);
    return [own.right, own.up, own.toEye].map((axis) => dot(toWorld(axis, hello.frame), world));
  },
  toWorld: (camera) => {
    const own = axes(state().camera);
    return toWorld(sum(times(own.right, camera[0]), times(own.up, camera[1]), times(own.toEye, camera[2])), hello.frame);
  },
});
const cutting = new Cutting({ change: changeLook, plane: newPlane });
const film = new Film({
  camera: () => state().camera,
  show: (camera) => { state().camera = camera; showCamera(); settle(); },
  send: (request) => connection.send(request),
  size: () => picture.size(),
});
const files = new Files({
  send: (request) => connection.send(request),
  problem: (sentence) => problem(sentence),
  transfer: async (file) => connection.send({ type: "read", name: file.name, text: await file.text() }),
});
const sides = new Sides((side) => look(side));
const connection = new Connection({ message, picture: receive, lost });

function state() {
  return /** @type {History} */ (history).now;
}

/** @param {any} text */
function message(text) {
  /** @type {Record<string, () => void>} */
  const answers = {
    hello: () => begin(text),
    ready: () => { isReady = text.ready; say(); },
    refined: () => {
      refinedId = text.id;
      if (refinedId === shown.id) shown.step = "refined";
      say();
    },
    fitted: () => fitted(text.camera),
    transfer: () => {
      state().transfer = { name: text.name, colors: text.colors, opacities: text.opacities };
      show();
      settle();
    },
    written: () => download(new Blob([text.text], { type: "text/plain" }), text.name),
    command: () => command(text),
    film_command: () => film.command(text),
    film: () => film.progress(text),
    problem: () => { files.say(""); problem(text.sentence); },
  };
  answers[text.type]?.();
}

/** A new connection: the first one, or one after a loss, with the same view. @param {any} first */
function begin(first) {
  if (hello && hello.scene !== first.scene) {
    // Another volume: nothing of the last one's state applies.
    history = null;
    film.clear();
    window.history.replaceState(null, "", location.pathname);
  }
  hello = first;
  element("problem").hidden = true;
  // Sent again: what the page sent last may have met the volume before.
  sent = { look: null, transfer: null };
  files.set(hello.offered, hello.volume.name);
  const { volume, histogram } = hello;
  element("name").textContent = volume.name;
  document.title = `${volume.name} – layersplat`;
  element("facts").textContent = `${volume.dims.join(" × ")} voxels of ${volume.voxel_type}, ${short(histogram.lowest)} to ${short(histogram.highest)}`;
  editor.setHistogram(histogram);
  cutting.setVolume(volume);
  controls.setRange(histogram.lowest, histogram.highest);
  sides.set(hello.sides);
  fillNames();
  if (history === null) {
    const initial = { camera: hello.camera, look: hello.look, transfer: hello.transfer };
    history = new History(initial);
    const kept = fromFragment(location.hash.slice(1), initial);
    if (kept) {
      history.now = kept;
      history.commit();
    } else if (!hello.camera_is_given) {
      awaits = "first";
    }
  }
  show();
  if (awaits === "first") connection.send({ type: "fit", camera: state().camera, ...picture.size() });
  else settle();
  field("save-width").value = String(picture.size().width);
  field("save-height").value = String(picture.size().height);
}

/** @param {string} reason */
function lost(reason) {
  film.giveUp();
  problem(reason || "The connection is lost. The page connects again by itself once layersplat answers.", "lost");
}

/** @param {import("./connection.js").Received} received */
async function receive(received) {
  if (received.step === "part") {
    film.part(received);
    return;
  }
  if (received.step === "saved") {
    download(received.blob, "layersplat.png");
    return;
  }
  await picture.draw(received);
  requestAnimationFrame(() => connection.send({ type: "shown" }));
  const step = received.id === refinedId ? "refined" : received.step;
  Object.assign(shown, { id: received.id, step, pictures: shown.pictures + 1 });
  times30 = [...times30.slice(-29), performance.now()];
  say(received);
}

/** Draws the view as fast as the hand moves. */
function move() {
  isMoving = true;
  request();
}

/** The hand rests: the picture is refined, and the state kept. */
function settle() {
  isMoving = false;
  request();
  history?.commit();
  keepAddress();
  showHistory();
}

/** Sends what the server does not have, and asks for a picture. */
function request() {
  if (!history || !connection.isOpen) return;
  const { camera, look: own, transfer } = state();
  const points = [transfer.colors, transfer.opacities];
  if (!isEqual(sent.look, own)) connection.send({ type: "look", look: own });
  if (!isEqual(sent.transfer, points)) connection.send({ type: "transfer", colors: points[0], opacities: points[1] });
  sent = { look: copy(own), transfer: copy(points) };
  id += 1;
  connection.send({ type: "view", id, camera, ...picture.size(), moving: isMoving });
}

/** @param {(look: Look) => void} change @param {boolean} isDone */
function changeLook(change, isDone) {
  const own = copy(state().look);
  change(own);
  state().look = own;
  show();
  if (isDone) settle();
  else move();
}

/** @param {(camera: import("./state.js").Camera) => import("./state.js").Camera} change */
function changeCamera(change) {
  if (!history) return;
  state().camera = change(state().camera);
  showCamera();
  move();
}

/** Rests after a while without keys. */
function restSoon() {
  clearTimeout(rest);
  rest = window.setTimeout(settle, KEY_REST);
}

/** @param {{ azimuth: number, elevation: number }} side */
function look({ azimuth, elevation }) {
  if (!history) return;
  state().camera = { ...state().camera, azimuth, elevation, roll: 0 };
  showCamera();
  settle();
}

function fit() {
  awaits = "fit";
  connection.send({ type: "fit", camera: state().camera, ...picture.size() });
}

/** @param {import("./state.js").Camera} camera */
function fitted(camera) {
  const now = state();
  now.camera = camera;
  if (awaits === "first" && history) {
    // The first view of this page: undo ends here.
    history.past = [copy(now)];
    history.at = 0;
    hello.camera = copy(camera);
  }
  awaits = "nothing";
  showCamera();
  settle();
}

function reset() {
  if (!history) return;
  history.now = { camera: copy(hello.camera), look: copy(hello.look), transfer: copy(hello.transfer) };
  show();
  settle();
}

/** @param {number} steps */
function go(steps) {
  if (!history?.go(steps)) return;
  show();
  settle();
}

/** A clip plane through the centre, whose visible side is away from the viewer. */
function newPlane() {
  const { camera } = state();
  const normal = times(toWorld(axes(camera).toEye, hello.frame), -1).map((x) => Number(x.toFixed(4)) + 0);
  return [...hello.volume.centre, ...unit(normal)];
}

function show({ exceptEditor = false } = {}) {
  if (!history) return;
  const { look: own, transfer } = state();
  if (!exceptEditor) editor.set(transfer);
  controls.show(own, hello.is_layered);
  lighting.set(own);
  cutting.set(own);
  picture.canvas.classList.toggle("transparent", own.background === "transparent");
  showCamera();
  showHistory();
}

function showCamera() {
  const { camera, look: own } = state();
  sides.draw(camera);
  if (!own.lights_follow) lighting.draw();
  const isPerspective = "perspective" in camera.projection;
  element("projection").setAttribute("aria-pressed", String(isPerspective));
}

function showHistory() {
  if (!history) return;
  element("undo").toggleAttribute("disabled", history.at === 0);
  element("redo").toggleAttribute("disabled", history.at === history.past.length - 1);
}

/** The status line. @param {import("./connection.js").Received} [received] */
function say(received) {
  const last = received ?? say.last;
  if (!last) return;
  say.last = last;
  const size = `${last.width} × ${last.height}`;
  const text = last.step === "moving"
    ? `${size}, ${rate()} frames/s`
    : `${size}, ${last.step === "half" ? "high" : shown.step}`;
  element("status").textContent = isReady ? text : `${text} – preparing programs for the device …`;
}
/** @type {import("./connection.js").Received | null} */
say.last = null;

function rate() {
  const recent = times30.filter((time) => time > performance.now() - 1000);
  if (recent.length < 2) return "–";
  return Math.round((1000 * (recent.length - 1)) / (recent[recent.length - 1] - recent[0]));
}

let problemTimer = 0;
/** @param {string} sentence @param {"problem" | "lost" | "note"} [kind] what is lost is shown until the connection is back */
function problem(sentence, kind = "problem") {
  const line = element("problem");
  line.classList.toggle("note", kind === "note");
  line.textContent = sentence.charAt(0).toUpperCase() + sentence.slice(1);
  line.hidden = false;
  clearTimeout(problemTimer);
  if (kind !== "lost") problemTimer = window.setTimeout(() => { line.hidden = true; }, PROBLEM_TIME);
}

let addressTimer = 0;
function keepAddress() {
  clearTimeout(addressTimer);
  addressTimer = window.setTimeout(() => {
    if (!history) return;
    const fragment = toFragment(state(), hello.transfer);
    window.history.replaceState(null, "", fragment === null ? location.pathname : `#${fragment}`);
  }, ADDRESS_TIME);
}

/** @param {number} number */
const short = (number) => String(Number(number.toPrecision(5)));

/** The list of named transfer functions, and the strips of colour maps. */
function fillNames() {
  const list = element("named");
  const option = (/** @type {string} */ value, /** @type {string} */ text) => {
    const item = document.createElement("option");
    [item.value, item.textContent] = [value, text];
    return item;
  };
  const group = (/** @type {string} */ label, /** @type {HTMLOptionElement[]} */ items) => {
    const part = document.createElement("optgroup");
    part.label = label;
    part.append(...items);
    return part;
  };
  list.replaceChildren(
    option("", "choose …"),
    option("initial:", "as at the start"),
    group("Automatic, in colours", hello.palettes.map((/** @type {string} */ name) => option(`automatic:${name}`, name))),
    group("Presets", hello.presets.map((/** @type {any} */ { name, shows }) => option(`preset:${name}`, `${name} – ${shows}`))),
  );
  const strip = element("maps");
  strip.replaceChildren(...hello.maps.map((/** @type {any} */ map) => swatch(map)));
}

/** A button with the colours of a map, which keeps the opacities. @param {{ name: string, colors: number[][] }} map */
function swatch({ name, colors }) {
  const [button, canvas] = [document.createElement("button"), document.createElement("canvas")];
  button.type = "button";
  button.title = button.ariaLabel = name;
  [canvas.width, canvas.height] = [46, 20];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const gradient = context.createLinearGradient(0, 0, canvas.width, 0);
  colors.forEach((rgb, n) => gradient.addColorStop(n / Math.max(colors.length - 1, 1), `rgb(${rgb.map((c) => Math.round(c * 255)).join(" ")})`));
  context.fillStyle = gradient;
  context.fillRect(0, 0, canvas.width, canvas.height);
  button.append(canvas);
  button.addEventListener("click", () => {
    const { transfer } = state();
    const values = transfer.opacities.filter(([, opacity]) => opacity > 0).map(([value]) => value);
    const { lowest, highest } = hello.histogram;
    const [low, high] = values.length > 1 ? [Math.min(...values), Math.max(...values)] : [lowest, highest];
    const end = Math.max(colors.length - 1, 1);
    transfer.colors = colors.map((rgb, n) => [low + ((high - low) * n) / end, [...rgb]]);
    transfer.name = name;
    show();
    settle();
  });
  return button;
}

/** @param {any} answer */
async function command({ line, transfer_name: name, transfer_text: text }) {
  const box = field("command");
  box.value = line;
  box.hidden = false;
  if (!wantsCommand) return;
  wantsCommand = false;
  download(new Blob([text], { type: "application/json" }), name);
  const isCopied = await toClipboard(line);
  const file = `It needs ${name}, which is saved as a download.`;
  problem(isCopied ? `The command is copied. ${file}` : `Copy the command from the panel. ${file}`, "note");
}

function savedSize() {
  const [width, height, samples] = ["save-width", "save-height", "save-samples"].map((name) => field(name).valueAsNumber || 1);
  return { camera: state().camera, width, height, samples };
}

const save = () => connection.send({ type: "save", ...savedSize() });
const copyCommand = () => {
  wantsCommand = true;
  connection.send({ type: "command", ...savedSize() });
};

function fold() {
  const isFolded = element("panel").classList.toggle("folded");
  element("fold").setAttribute("aria-expanded", String(!isFolded));
  document.body.classList.toggle("panel-open", !isFolded);
}

const help = () => /** @type {HTMLDialogElement} */ (element("help")).showModal();

function listen() {
  const turn = (/** @type {number} */ x, /** @type {number} */ y) => changeCamera((camera) => turned(camera, x, y));
  const pan = (/** @type {number} */ x, /** @type {number} */ y) => changeCamera((camera) => panned(camera, x, y, hello.frame));
  const zoom = (/** @type {number} */ factor, /** @type {number} */ x, /** @type {number} */ y) => {
    changeCamera((camera) => zoomed(camera, factor, x, y, hello.frame));
  };
  const roll = (/** @type {number} */ degrees) => changeCamera((camera) => rolled(camera, degrees));
  gestures.listen(picture, { turn, pan, zoom, roll, rest: settle });
  const held = (/** @type {() => void} */ action) => () => { action(); restSoon(); };
  const arrows = (/** @type {string} */ prefix, /** @type {(x: number, y: number) => void} */ action, /** @type {number} */ step) => ({
    [`${prefix}ArrowLeft`]: held(() => action(-step, 0)), [`${prefix}ArrowRight`]: held(() => action(step, 0)),
    [`${prefix}ArrowUp`]: held(() => action(0, step)), [`${prefix}ArrowDown`]: held(() => action(0, -step)),
  });
  const corner = (/** @type {number} */ azimuth) => () => look({ azimuth, elevation: 35.264389682754654 });
  keys.listen({
    ...arrows("", turn, KEY_TURN), ...arrows("Shift+", pan, KEY_PAN),
    "+": held(() => zoom(KEY_ZOOM, 0, 0)), "=": held(() => zoom(KEY_ZOOM, 0, 0)), "-": held(() => zoom(1 / KEY_ZOOM, 0, 0)),
    ",": held(() => roll(-5)), ".": held(() => roll(5)),
    ...Object.fromEntries([0, 1, 2, 3, 4, 5].map((n) => [String(n + 1), () => look(hello.sides[n])])),
    "7": corner(45), "8": corner(225),
    f: fit, r: reset, o: () => { changeCamera(otherProjection); settle(); }, p: fold, k: () => film.record(), s: save, c: copyCommand, "?": help,
    "Ctrl+z": () => go(-1), "Ctrl+y": () => go(1), "Ctrl+Shift+z": () => go(1),
  });
  controls.listen(changeLook);
  const click = (/** @type {string} */ name, /** @type {() => void} */ action) => element(name).addEventListener("click", action);
  click("fold", fold);
  click("undo", () => go(-1));
  click("redo", () => go(1));
  click("reset", reset);
  click("help-button", help);
  click("fit", fit);
  click("projection", () => { changeCamera(otherProjection); settle(); });
  click("save", save);
  click("copy", copyCommand);
  click("load-transfer", () => field("transfer-file").click());
  field("transfer-file").addEventListener("change", async () => {
    const file = field("transfer-file").files?.[0];
    field("transfer-file").value = "";
    if (file) connection.send({ type: "read", name: file.name, text: await file.text() });
  });
  field("save-transfer").addEventListener("change", () => {
    const format = field("save-transfer").value;
    field("save-transfer").value = "";
    if (format) connection.send({ type: "write", name: `layersplat.${format}` });
  });
  field("named").addEventListener("change", () => {
    const [kind, name] = field("named").value.split(":");
    field("named").value = "";
    if (kind) connection.send({ type: "named", kind, name });
  });
  new ResizeObserver(() => { if (history && awaits === "nothing") settle(); }).observe(picture.canvas);
  addEventListener("hashchange", () => {
    const kept = history && fromFragment(location.hash.slice(1), { camera: hello.camera, look: hello.look, transfer: hello.transfer });
    if (!kept || !history) return;
    history.now = kept;
    show();
    settle();
  });
}

keys.fill(element("keys"));
if (innerWidth <= 640) fold();
else document.body.classList.add("panel-open");
listen();
