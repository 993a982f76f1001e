// Three slices beside the picture, with a crosshair that all share.

import { dot, sum, times, unit } from "./camera.js";
import { isEqual } from "./state.js";

/**
 * @typedef {{ name: string, right: number[], up: number[], step: number[], offset: number, per_unit: number[], range: number[] }} Axis
 *   `step`: world vector to the next slice; a world point p has the coordinate per_unit·p + offset
 * @typedef {{ name: string, right: number[], up: number[], step: number[] }} Plane
 * @typedef {{ corner: number[], right: number[], down: number[] }} Placed
 * @typedef {import("./state.js").SlicesState} Own
 * @typedef {{ send: (request: object) => void, axes: () => number[][], change: (own: Own, isDone: boolean) => void }} Page
 *   `axes`: of the camera, in the world: right, up, to the eye
 */

/** Colours of the planes: of their names, and of their lines in the other slices. */
const COLORS = ["#ff6b6b", "#5fd37a", "#6cb0ff"];
/** Most pixels of a slice. */
const MOST_PIXELS = 1_000_000;
/** Turn of the wheel per slice. */
const NOTCH = 100;
/** Milliseconds after the last turn of the wheel or the last key at which the hand rests. */
const REST = 200;
/** Pixels of a drag that widen a window e times. */
const WIDEN = 150;
/** Least width of a window, and least thickness: above 0. */
const LEAST_WIDTH = 1e-9;

/** @param {string} id */
const element = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));
/** @param {number} number */
const short = (number) => String(Number(number.toPrecision(5)));

/** @param {number[]} a @param {number[]} b */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** The letter of a patient's side that a world direction points to. @param {number[]} direction */
function side(direction) {
  const axis = direction.map(Math.abs).reduce((best, x, n, all) => (x > all[best] ? n : best), 0);
  return ["LR", "PA", "IS"][axis][direction[axis] > 0 ? 1 : 0];
}

/** The slices before anything is changed. @param {any} hello @returns {Own} */
export const firstSlices = (hello) => ({
  shown: false, point: [...hello.volume.centre], planes: "axes", colors: "window", kernel: "linear", window: [...hello.slices.window], thickness: 1,
});

export class Slices {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Own} */
    this.own = { shown: false, point: [0, 0, 0], planes: "axes", colors: "window", kernel: "linear", window: [0, 1], thickness: 1 };
    /** @type {{ axes: Axis[], has_anatomy: boolean, window: number[] } | null} */
    this.volume = null;
    this.spacing = 1;
    /** @type {unknown} */
    this.scene = null;
    /** The parts of the page's state on which slices depend. */
    this.context = { transfer: /** @type {unknown} */ (null), background: "" };
    this.requested = 0;
    /** Of the last picture. */
    this.shown = 0;
    /** What was asked for last. */
    this.sent = { key: "", isMoving: false };
    /** @type {ImageBitmap | null} */
    this.bitmap = null;
    /** Where the slices of the picture lie. @type {Placed[]} */
    this.placed = [];
    /** What comes with the next picture. @type {Placed[]} */
    this.next = [];
    this.timer = 0;
    const section = element("slices");
    this.views = [0, 1, 2].map((n) => this.view(n, section));
    this.listen();
  }

  /** A new connection: everything is asked for again. @param {any} hello */
  begin(hello) {
    if (hello.scene !== this.scene) {
      // The slices of another volume are gone, those on their way, too.
      this.bitmap?.close();
      [this.bitmap, this.placed, this.shown] = [null, [], this.requested];
      for (const { canvas, name } of this.views) {
        canvas.getContext("2d")?.clearRect(0, 0, canvas.width, canvas.height);
        name.textContent = "";
      }
    }
    this.scene = hello.scene;
    this.volume = hello.slices;
    this.spacing = Math.min(...hello.volume.spacing);
    this.sent.key = "";
  }

  /** World point of the crosshair. */
  get point() {
    return this.own.point;
  }

  /** Shows the slices of a state. @param {Own} own */
  set(own) {
    if (!isEqual(own, this.own)) this.apply(own);
  }

  /** @param {Own} own */
  apply(own) {
    this.own = structuredClone(own);
    element("slices").hidden = !own.shown;
    document.body.classList.toggle("slices-open", own.shown);
    this.show();
    this.paint();
    this.ask(false);
  }

  /** @param {Partial<Own>} changes @param {boolean} isDone */
  change(changes, isDone) {
    const own = { ...this.own, ...changes };
    this.apply(own);
    this.page.change(structuredClone(own), isDone);
  }

  toggle() {
    this.change({ shown: !this.own.shown }, true);
  }

  /** The page's transfer function, background or camera may have changed. @param {unknown} transfer @param {string} background
   * @param {boolean} isMoving */
  follow(transfer, background, isMoving) {
    this.context = { transfer, background };
    this.ask(isMoving);
  }

  /** @returns {Plane[]} */
  get planes() {
    const axes = this.volume?.axes ?? [];
    if (this.own.planes !== "camera") return axes;
    const [right, up, toEye] = this.page.axes();
    const plane = (/** @type {string} */ name, /** @type {number[]} */ r, /** @type {number[]} */ u) => {
      return { name, right: r, up: u, step: times(unit(cross(r, u)), this.spacing) };
    };
    return [plane("facing", right, up), plane("from above", right, times(toEye, -1)), plane("from the side", times(toEye, -1), up)];
  }

  /** Size of each slice in device pixels. */
  size() {
    const { clientWidth, clientHeight } = this.views[0].canvas;
    const [w, h] = [Math.max(clientWidth, 1), Math.max(clientHeight, 1)];
    const ratio = Math.min(devicePixelRatio || 1, Math.sqrt(MOST_PIXELS / (w * h)));
    return { width: Math.max(1, Math.round(w * ratio)), height: Math.max(1, Math.round(h * ratio)) };
  }

  /** Asks for slices, unless they are those that were asked for. @param {boolean} isMoving */
  ask(isMoving) {
    const { shown, point, colors, kernel, window, thickness } = this.own;
    if (!shown || !this.volume) return;
    const request = {
      type: "slices", point, planes: this.planes.map(({ right, up }) => ({ right, up })), ...this.size(), kernel,
      window: colors === "window" ? window : null,
      thickness: colors === "opacity" ? thickness : null,
    };
    const { transfer, background } = this.context;
    const key = JSON.stringify([request, background, colors === "window" ? null : transfer]);
    if (key === this.sent.key && (isMoving || !this.sent.isMoving)) return;
    this.sent = { key, isMoving };
    this.requested += 1;
    this.page.send({ ...request, id: this.requested, moving: isMoving });
    this.showAge();
  }

  /** @param {{ value: number | null, placed: Placed[] }} answer */
  answer({ value, placed }) {
    this.next = placed;
    element("slices-value").textContent = value === null ? "outside" : short(value);
  }

  /** @param {import("./connection.js").Received} received */
  async draw({ blob, id }) {
    const placed = this.next;
    const bitmap = await createImageBitmap(blob);
    // Decoding may change the order.
    if (id <= this.shown) {
      bitmap.close();
      return;
    }
    this.bitmap?.close();
    this.bitmap = bitmap;
    this.placed = placed;
    this.shown = id;
    this.showAge();
    this.paint();
  }

  /** Slices of an earlier request are dimmed, unless a hand moves: they follow it. */
  showAge() {
    element("slices").classList.toggle("old", this.shown < this.requested && !this.sent.isMoving);
  }

  /** The pictures as they came, and the crosshair where it is. */
  paint() {
    const { bitmap } = this;
    if (!bitmap) return;
    const { width, height } = this.size();
    const planes = this.planes;
    this.views.forEach(({ canvas, name }, n) => {
      if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
      const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
      context.clearRect(0, 0, width, height);
      context.drawImage(bitmap, 0, (n * bitmap.height) / 3, bitmap.width, bitmap.height / 3, 0, 0, width, height);
      this.mark(context, n, planes);
      name.textContent = `${planes[n].name}${this.coordinate(n)}`;
    });
  }

  /** The lines of the other two planes, and the sides of a patient. @param {CanvasRenderingContext2D} context @param {number} n @param {Plane[]} planes */
  mark(context, n, planes) {
    const { width, height } = context.canvas;
    const [x, y] = this.pixel(n, this.point);
    const ratio = width / Math.max(this.views[n].canvas.clientWidth, 1);
    context.lineWidth = ratio;
    planes.forEach((plane, other) => {
      if (other === n) return;
      const isUpright = Math.abs(dot(unit(plane.step), planes[n].right)) > 0.5;
      context.strokeStyle = COLORS[other];
      context.beginPath();
      // The place itself stays free.
      const gap = 5 * ratio;
      const lines = isUpright ? [[x, 0, x, y - gap], [x, y + gap, x, height]] : [[0, y, x - gap, y], [x + gap, y, width, y]];
      lines.forEach(([x0, y0, x1, y1]) => { context.moveTo(x0, y0); context.lineTo(x1, y1); });
      context.stroke();
    });
    if (!this.volume?.has_anatomy) return;
    context.fillStyle = "#d8dee4";
    context.strokeStyle = "#000";
    context.font = `${12 * ratio}px system-ui, sans-serif`;
    [context.textAlign, context.textBaseline] = ["center", "middle"];
    const { right, up } = planes[n];
    const at = 10 * ratio;
    /** @type {[number[], number, number][]} */
    const letters = [[right, width - at, height / 2], [times(right, -1), at, height / 2], [times(up, -1), width / 2, height - at], [up, width / 2, at]];
    letters.forEach(([direction, left, top]) => {
      context.strokeText(side(direction), left, top);
      context.fillText(side(direction), left, top);
    });
  }

  /** Place of a world point in a slice. @param {number} n @param {number[]} point */
  pixel(n, point) {
    const { corner, right, down } = this.placed[n];
    const from = point.map((p, i) => p - corner[i]);
    const { bitmap } = this;
    const { width, height } = this.views[n].canvas;
    const [w, h] = [bitmap?.width ?? 1, (bitmap?.height ?? 3) / 3];
    return [(dot(from, right) / dot(right, right) / w) * width, (dot(from, down) / dot(down, down) / h) * height];
  }

  /** World point of the slice under a pointer, in the plane through the crosshair. @param {number} n @param {MouseEvent} event */
  place(n, event) {
    const { left, top, width, height } = this.views[n].canvas.getBoundingClientRect();
    const { corner, right, down } = this.placed[n];
    const [w, h] = [this.bitmap?.width ?? 1, (this.bitmap?.height ?? 3) / 3];
    const point = sum(corner, sum(times(right, ((event.clientX - left) / width) * w), times(down, ((event.clientY - top) / height) * h)));
    const normal = unit(this.planes[n].step);
    return sum(point, times(normal, dot(normal, this.point) - dot(normal, point)));
  }

  /** The coordinate of a slice along its axis, as a text. @param {number} n */
  coordinate(n) {
    const axis = this.own.planes === "camera" ? null : this.volume?.axes[n];
    return axis ? ` ${(dot(axis.per_unit, this.point) + axis.offset).toFixed(1)}` : "";
  }

  /** Moves the crosshair, within the volume. @param {number[]} point @param {boolean} isMoving */
  moveTo(point, isMoving) {
    const inside = (this.volume?.axes ?? []).reduce((p, { per_unit: along, offset, range, step }) => {
      const at = dot(along, p) + offset;
      const by = Math.min(Math.max(at, range[0]), range[1]) - at;
      return by === 0 ? p : sum(p, times(step, by / dot(along, step)));
    }, point);
    this.follows({ point: inside }, isMoving);
  }

  /** A change by a hand that may move on. @param {Partial<Own>} changes @param {boolean} isMoving */
  follows(changes, isMoving) {
    if (!isMoving) {
      this.change(changes, true);
      return;
    }
    this.own = { ...this.own, ...changes };
    this.show();
    this.paint();
    this.ask(true);
  }

  /** The hand rests: the state is kept. */
  rest() {
    this.change({}, true);
  }

  /** Rests after a while. */
  restSoon() {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.rest(), REST);
  }

  /** The controls of the panel. */
  show() {
    const { shown, point, planes, colors, kernel, window, thickness } = this.own;
    element("slices-shown").checked = shown;
    const names = { "slices-planes": planes, "slices-colors": colors, "slices-kernel": kernel };
    for (const [id, name] of Object.entries(names)) element(id).value = name;
    const numbers = {
      "slices-level": window[0], "slices-width": window[1], "slices-thickness": thickness, "slices-x": point[0], "slices-y": point[1], "slices-z": point[2],
    };
    for (const [id, number] of Object.entries(numbers)) if (element(id) !== document.activeElement) element(id).value = short(number);
    element("slices-window").hidden = colors !== "window";
    element("slices-thickness-line").hidden = colors !== "opacity";
  }

  /** A canvas with its name. @param {number} n @param {HTMLElement} section */
  view(n, section) {
    const [box, canvas, name] = [document.createElement("div"), document.createElement("canvas"), document.createElement("p")];
    box.className = "slice";
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", `Slice ${n + 1}. Arrow keys move the crosshair, Page Up and Page Down the slice.`);
    name.style.color = COLORS[n];
    box.append(canvas, name);
    section.append(box);
    let turned = 0;
    canvas.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      if (event.button === 0 && this.placed.length > 0) this.moveTo(this.place(n, event), true);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!canvas.hasPointerCapture(event.pointerId) || this.placed.length === 0) return;
      if (event.buttons & 2) this.changeWindow(event);
      else if (event.buttons & 1) this.moveTo(this.place(n, event), true);
    });
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) canvas.addEventListener(end, () => this.rest());
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      turned += event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 * event.deltaY : event.deltaY;
      const steps = Math.trunc(turned / NOTCH);
      turned -= steps * NOTCH;
      if (steps !== 0) this.moveTo(sum(this.point, times(this.planes[n].step, -steps)), true);
      this.restSoon();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const { right, up, step } = this.planes[n];
      /** @type {Record<string, number[]>} */
      const moves = {
        ArrowRight: times(right, this.spacing), ArrowLeft: times(right, -this.spacing), ArrowUp: times(up, this.spacing),
        ArrowDown: times(up, -this.spacing), PageUp: step, PageDown: times(step, -1),
      };
      const move = moves[event.key];
      if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      this.moveTo(sum(this.point, move), true);
      this.restSoon();
    });
    return { canvas, name };
  }

  /** As radiologists do: to the right is wider, upwards is darker. @param {PointerEvent} event */
  changeWindow({ movementX, movementY }) {
    if (this.own.colors !== "window") return;
    const [level, width] = this.own.window;
    this.follows({ window: [level - (movementY * width) / WIDEN / 2, Math.max(width * Math.exp(movementX / WIDEN), LEAST_WIDTH)] }, true);
  }

  listen() {
    element("slices-shown").addEventListener("change", () => this.toggle());
    for (const name of /** @type {const} */ (["planes", "kernel", "colors"])) {
      element(`slices-${name}`).addEventListener("change", () => this.change({ [name]: element(`slices-${name}`).value }, true));
    }
    const number = (/** @type {string} */ id, /** @type {(number: number) => void} */ set) => element(id).addEventListener("change", () => {
      const value = element(id).valueAsNumber;
      if (Number.isFinite(value)) set(value);
    });
    number("slices-level", (level) => this.change({ window: [level, this.own.window[1]] }, true));
    number("slices-width", (width) => this.change({ window: [this.own.window[0], Math.max(width, LEAST_WIDTH)] }, true));
    number("slices-thickness", (thickness) => this.change({ thickness: Math.max(thickness, LEAST_WIDTH) }, true));
    ["slices-x", "slices-y", "slices-z"].forEach((id, n) => {
      number(id, (value) => this.moveTo(this.point.map((p, i) => (i === n ? value : p)), false));
    });
    new ResizeObserver(() => this.ask(false)).observe(this.views[0].canvas);
  }
}
