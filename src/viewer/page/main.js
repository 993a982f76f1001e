// The page: one state, shown by all parts and sent to the server.

import { dot, otherProjection, panned, rolled, sum, times, turned, unit, worldAxes, zoomed } from "./camera.js";
import { Channels, shaded } from "./channels.js";
import * as controls from "./controls.js";
import { Cutting } from "./cutting.js";
import { Editor } from "./editor.js";
import { Files } from "./files.js";
import { Film } from "./film.js";
import * as gestures from "./gestures.js";
import { Handles } from "./handles.js";
import { Keeping } from "./keeping.js";
import * as keys from "./keys.js";
import { Lighting } from "./lighting.js";
import * as names from "./names.js";
import { Overlay } from "./overlay.js";
import { Picture } from "./picture.js";
import { Reading } from "./reading.js";
import { download } from "./saving.js";
import { Session } from "./session.js";
import { CORNER_ELEVATION, Sides } from "./sides.js";
import { Slices } from "./slices.js";
import { Status } from "./status.js";
import { Time } from "./time.js";
import * as unavailable from "./unavailable.js";

/** Radians and half heights per press of a key. */
const KEY_TURN = (5 * Math.PI) / 180;
const KEY_PAN = 0.05;
const KEY_ZOOM = 1.1;

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

const picture = new Picture(/** @type {HTMLCanvasElement} */ (element("picture")));
const status = new Status();
const note = (/** @type {string} */ sentence) => status.problem(sentence, "note");
const session = new Session(picture, { say: note, show, showCamera, showHistory, showTime: () => time.show(), asked: (what) => status.ask(what), requested }, {
  message, picture: receive,
  lost: (reason, isBad) => {
    if (isBad) session.forget();
    film.giveUp();
    files.end();
    status.ask("");
    time.pause();
    status.problem(reason || "The connection is lost. The page connects again by itself once layersplat answers.", "lost");
  },
});
const editor = new Editor({
  changed: (transfer) => { session.transfer = transfer; show({ exceptEditor: true }); session.move(); },
  rest: () => session.settle(),
  iso: (value, isDone) => session.changeLook((look) => { look.iso = value; }, isDone),
  isTent: () => reading.tool === "tent",
});
const changeLook = session.changeLook.bind(session);
const lighting = new Lighting({
  change: changeLook,
  toCamera: (world) => {
    const own = worldAxes(session.state.camera, session.hello.frame);
    return [own.right, own.up, own.toEye].map((axis) => dot(axis, world));
  },
  toWorld: (camera) => {
    const own = worldAxes(session.state.camera, session.hello.frame);
    return sum(times(own.right, camera[0]), times(own.up, camera[1]), times(own.toEye, camera[2]));
  },
});
const channels = new Channels({
  change: changeLook,
  choose: (field) => {
    session.field = field;
    editor.setHistogram(session.histogram);
    show();
  },
  recolor: (field, color, isDone) => {
    const transfer = field === 0 ? session.state.transfer : session.state.others[field - 1];
    session.changeField(field, shaded(transfer, color), (look) => { look.channels[field].color = color; }, isDone);
  },
});
const cutting = new Cutting({ change: changeLook, plane: newPlane });
const time = new Time(session, status);
const film = new Film({
  shown: () => ({ camera: session.state.camera, frame: session.state.look.frame }),
  show: ({ camera, frame }) => {
    session.changeCamera(() => camera);
    if (frame === session.state.look.frame) session.settle();
    else session.changeStep(frame, true);
  },
  steps: () => session.hello.steps,
  send: (request) => session.connection.send(request),
  size: () => picture.size(),
});
const files = new Files({
  send: (request) => session.connection.send(request),
  problem: (sentence) => status.problem(sentence),
  coming: (text) => status.come(text),
  transfer: async (file) => session.connection.send({ type: "read", field: session.field, name: file.name, text: await file.text() }),
});
const sides = new Sides((side) => session.look(side));
const keeping = new Keeping(session, status);
const slices = new Slices({
  change: (own, isDone) => session.keepSlices(own, isDone),
  send: (request) => session.connection.send(request),
  axes: () => {
    const own = worldAxes(session.state.camera, session.hello.frame);
    return [own.right, own.up, own.toEye];
  },
});
const handles = new Handles(session, cutting);
const reading = new Reading(session, {
  draw: () => overlay.draw(),
  tent: (value) => editor.showAround(value, /** @type {HTMLInputElement} */ (element("tent-alone")).checked),
  say: note,
});
const overlay = new Overlay(picture, () => {
  if (!session.history) return;
  handles.paint(overlay);
  reading.paint(overlay);
});

// For tests.
Object.assign(globalThis, {
  layersplat: { shown: status.shown, requested: () => session.id, state: () => session.history?.now, connection: () => session.connection, slices: () => slices },
});

/** Slices follow what views are asked with. @param {{ id: number, isOther: boolean, transfer: unknown, background: string, isMoving: boolean }} own */
function requested({ id, isOther, transfer, background, isMoving }) {
  status.request(id, isOther, isMoving);
  slices.follow(transfer, background, isMoving);
}

/** @param {any} text */
function message(text) {
  /** @type {Record<string, () => void>} */
  const answers = {
    hello: () => begin(text),
    ready: () => status.ready(text.ready),
    refined: () => status.refined(text.id),
    work: () => status.working(text),
    failed: () => status.failed(text.id),
    given: () => session.give(text),
    fitted: () => {
      status.ask("");
      session.fitted(text.camera);
    },
    transfer: () => {
      status.ask("");
      session.setTransfer({ name: text.name, colors: text.colors, opacities: text.opacities }, text.field);
    },
    written: () => download(new Blob([text.text], { type: "text/plain" }), text.name),
    command: () => keeping.show(text),
    slices: () => slices.answer(text),
    film_command: () => film.command(text),
    film: () => film.progress(text),
    opening: () => files.progress(text),
    picked: () => reading.picked(text),
    problem: () => {
      status.ask("");
      time.pause();
      session.fitFailed();
      status.problem(text.sentence);
      if (text.undo) session.takeBack();
    },
  };
  answers[text.type]?.();
}

/** @param {any} hello */
function begin(hello) {
  status.clear();
  const { volume, histogram } = hello;
  if (session.hello?.scene !== hello.scene) {
    // Nothing of another volume stays: its picture is old, its distances and its commands are gone.
    status.begin(session.id);
    film.clear();
    keeping.clear();
    reading.begin();
    if (hello.notes.length > 0) note(hello.notes.join(" "));
  }
  files.set(hello, volume.name);
  element("name").textContent = volume.name;
  document.title = `${volume.name} – layersplat`;
  const { labels, unavailable } = hello;
  // Labels alone have no curve.
  const values = labels.length > 0 && "curve" in unavailable ? [] : [`${volume.voxel_type}, ${short(histogram.lowest)} to ${short(histogram.highest)}`];
  const channelsSaid = hello.channels.length > 1 ? [`${hello.channels.length} channels`] : [];
  const content = [...values, ...channelsSaid, ...(labels.length > 0 ? [`${labels.length} labels`] : [])].join(", ");
  element("facts").textContent = `${volume.dims.join(" × ")} voxels of ${content}`;
  editor.setHistogram(histogram);
  cutting.setVolume(volume);
  controls.setRange(histogram.lowest, histogram.highest);
  controls.fill(hello.choices);
  controls.make(hello.settings, changeLook);
  sides.set(hello.sides);
  channels.begin(hello);
  lighting.begin(hello);
  slices.begin(hello);
  time.begin(hello.steps);
  session.begin(hello);
  names.fill(session);
  keeping.offerSize();
}

/** @param {number} number */
const short = (number) => String(Number(number.toPrecision(5)));

/** @param {import("./connection.js").Received} received */
async function receive(received) {
  if (received.step === "saved") {
    download(received.blob, received.blob.type === "image/png" ? "layersplat.png" : "layersplat.exr");
    return;
  }
  if (received.step === "part") {
    film.part(received);
    return;
  }
  if (received.step === "slices") {
    await slices.draw(received);
    status.working(null);
    requestAnimationFrame(() => session.connection.send({ type: "shown" }));
    return;
  }
  const isShown = await picture.draw(received);
  requestAnimationFrame(() => session.connection.send({ type: "shown" }));
  if (isShown) status.draw(received);
  time.drawn();
}

/** A clip plane through the centre, whose visible side is away from the viewer. */
function newPlane() {
  const { frame, volume } = session.hello;
  const normal = times(worldAxes(session.state.camera, frame).toEye, -1).map((x) => Number(x.toFixed(4)) + 0);
  return [...volume.centre, ...unit(normal)];
}

function show({ exceptEditor = false } = {}) {
  if (!session.history) return;
  const { look } = session.state;
  if (!exceptEditor) editor.set(session.transfer);
  channels.show(look, session.field);
  editor.setIso(look.blend === "iso" ? look.iso : null);
  controls.show(look, session.hello.is_layered);
  lighting.set(look);
  cutting.set(look);
  slices.set(session.state.slices);
  unavailable.show(session.hello.unavailable);
  // The axes are in the corner of the cube.
  element("stage").classList.toggle("with-axes", look.axes);
  picture.canvas.classList.toggle("transparent", look.background === "transparent");
  showCamera();
  showHistory();
  time.show();
}

function showCamera() {
  const { camera, look } = session.state;
  sides.draw(camera);
  if (!look.lights_follow) lighting.draw();
  overlay.draw();
  element("projection").setAttribute("aria-pressed", String("perspective" in camera.projection));
}

function showHistory() {
  if (!session.history) return;
  element("undo").toggleAttribute("disabled", session.history.at === 0);
  element("redo").toggleAttribute("disabled", session.history.at === session.history.past.length - 1);
}

function fold() {
  const isFolded = element("panel").classList.toggle("folded");
  element("fold").setAttribute("aria-expanded", String(!isFolded));
  document.body.classList.toggle("panel-open", !isFolded);
}

function help() {
  /** @type {HTMLDialogElement} */ (element("help")).showModal();
  // The button at its end has the focus.
  element("help").scrollTop = 0;
}

function listen() {
  const change = session.changeCamera.bind(session);
  const turn = (/** @type {number} */ x, /** @type {number} */ y) => {
    change((camera) => turned(camera, x, y, reading.pivot, session.hello.frame));
  };
  const pan = (/** @type {number} */ x, /** @type {number} */ y) => change((camera) => panned(camera, x, y, session.hello.frame));
  const zoom = (/** @type {number} */ factor, /** @type {number} */ x, /** @type {number} */ y) => {
    change((camera) => zoomed(camera, factor, x, y, session.hello.frame, session.hello.volume.diagonal));
  };
  const roll = (/** @type {number} */ degrees) => change((camera) => rolled(camera, degrees));
  const project = () => { change(otherProjection); session.settle(); };
  const hasMomentum = () => /** @type {HTMLInputElement} */ (element("momentum")).checked;
  gestures.listen(picture, {
    turn, pan, zoom, roll, hasMomentum, rest: () => session.settle(),
    grab: (place) => (session.history ? handles.grab(place, overlay.pixel) : null),
    click: (place) => reading.click(place), pivot: (place) => { if (reading.tool === "turn") reading.choosePivot(place); },
  });
  const toggle = (/** @type {"legend" | "bounding_box" | "axes"} */ name) => () => changeLook((look) => { look[name] = !look[name]; }, true);
  const reset = () => { reading.pivot = null; session.reset(); };
  const held = (/** @type {() => void} */ action) => () => { action(); session.restSoon(); };
  const arrows = (/** @type {string} */ prefix, /** @type {(x: number, y: number) => void} */ action, /** @type {number} */ step) => ({
    [`${prefix}ArrowLeft`]: held(() => action(-step, 0)), [`${prefix}ArrowRight`]: held(() => action(step, 0)),
    [`${prefix}ArrowUp`]: held(() => action(0, step)), [`${prefix}ArrowDown`]: held(() => action(0, -step)),
  });
  const corner = (/** @type {number} */ azimuth) => () => session.look({ azimuth, elevation: CORNER_ELEVATION });
  keys.listen({
    ...arrows("", turn, KEY_TURN), ...arrows("Shift+", pan, KEY_PAN),
    "+": held(() => zoom(KEY_ZOOM, 0, 0)), "=": held(() => zoom(KEY_ZOOM, 0, 0)), "-": held(() => zoom(1 / KEY_ZOOM, 0, 0)),
    ",": held(() => roll(-5)), ".": held(() => roll(5)),
    ...Object.fromEntries([0, 1, 2, 3, 4, 5].map((n) => [String(n + 1), () => session.look(session.hello.sides[n])])),
    "7": corner(45), "8": corner(225),
    f: () => session.fit(), r: reset, o: project, p: fold, v: () => { if (session.hello.unavailable.slices) note(session.hello.unavailable.slices); else slices.toggle(); }, "?": help,
    k: () => film.record(), s: () => keeping.save(), c: () => keeping.copy("line"), y: () => keeping.copy("python"),
    m: () => reading.toggle("measure"), t: () => reading.toggle("tent"), Escape: () => { if (!files.cancel()) reading.putAway(); },
    " ": () => time.toggle(), "[": () => time.step(-1), "]": () => time.step(1),
    d: () => reading.choosePivot({ x: 0, y: 0 }), l: toggle("legend"), b: toggle("bounding_box"), x: toggle("axes"),
    "Ctrl+z": () => session.go(-1), "Ctrl+y": () => session.go(1), "Ctrl+Shift+z": () => session.go(1),
  });
  controls.listen(changeLook);
  const click = (/** @type {string} */ name, /** @type {() => void} */ action) => element(name).addEventListener("click", action);
  click("fold", fold);
  click("undo", () => session.go(-1));
  click("redo", () => session.go(1));
  click("reset", reset);
  click("help-button", help);
  click("fit", () => session.fit());
  click("projection", project);
  element("handles").addEventListener("change", () => {
    const beyond = session.history ? handles.beyond(picture.canvas.clientWidth / picture.canvas.clientHeight) : 1;
    if (beyond > 1) {
      zoom(1 / beyond, 0, 0);
      session.settle();
    }
    overlay.draw();
  });
  names.listen(session);
  session.listen();
}

keys.fill(element("keys"));
if (innerWidth <= 640) fold();
else document.body.classList.add("panel-open");
listen();
