// The editor of the transfer function: a curve over the histogram, and the colours below.

import { add, adjusted, at, clamp, fromHeight, fromHex, move, toHeight, toHex } from "./editing.js";
import { copy } from "./state.js";

/** @typedef {import("./state.js").Transfer} Transfer */
/** @typedef {{ lowest: number, highest: number, counts: number[] }} Histogram */

/** Pixels within which a point is caught. */
const CATCH = 12;
/** Part of the range that a key moves a point by. */
const KEY_STEP = 1 / 100;
/** Room beside the curve in pixels, so that the outer points can be caught. */
const SIDE = 10;
/** Room above and below. */
const EDGE = 9;

/** @param {string} id */
const element = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

export class Editor {
  /** @param {{ changed: (transfer: Transfer) => void, rest: () => void }} handlers */
  constructor(handlers) {
    this.handlers = handlers;
    this.curve = /** @type {HTMLCanvasElement} */ (document.getElementById("curve"));
    this.colors = /** @type {HTMLCanvasElement} */ (document.getElementById("colors"));
    /** @type {Histogram} */
    this.histogram = { lowest: 0, highest: 1, counts: [] };
    /** @type {Transfer} */
    this.transfer = { name: "", colors: [[0, [1, 1, 1]]], opacities: [[0, 0]] };
    /** @type {{ list: "colors" | "opacities", index: number }} */
    this.chosen = { list: "opacities", index: 0 };
    this.listenTo(this.curve, "opacities");
    this.listenTo(this.colors, "colors");
    this.listenToPoint();
    this.listenToSliders();
    for (const id of ["log-counts", "log-opacity"]) element(id).addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.curve);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  /** @param {Histogram} histogram */
  setHistogram(histogram) {
    this.histogram = histogram;
  }

  /** Shows a transfer function that was changed elsewhere. @param {Transfer} transfer */
  set(transfer) {
    this.transfer = copy(transfer);
    this.chosen.index = clamp(this.chosen.index, 0, this.transfer[this.chosen.list].length - 1);
    this.showPoint();
    this.draw();
  }

  /** The values that the curve spans: those of the data and of all points. */
  get range() {
    const { lowest, highest } = this.histogram;
    const { colors, opacities } = this.transfer;
    const values = [...colors, ...opacities].map(([x]) => x);
    const [low, high] = [Math.min(lowest, ...values), Math.max(highest, ...values)];
    return high > low ? [low, high] : [low - 0.5, low + 0.5];
  }

  /** @param {number} value @param {HTMLCanvasElement} canvas */
  toX(value, canvas) {
    const [low, high] = this.range;
    return SIDE + ((value - low) / (high - low)) * (canvas.clientWidth - 2 * SIDE);
  }

  /** @param {number} x @param {HTMLCanvasElement} canvas */
  toValue(x, canvas) {
    const [low, high] = this.range;
    return low + clamp((x - SIDE) / (canvas.clientWidth - 2 * SIDE), 0, 1) * (high - low);
  }

  /** @param {number} opacity */
  toY(opacity) {
    const height = this.curve.clientHeight - 2 * EDGE;
    return EDGE + (1 - toHeight(opacity, element("log-opacity").checked)) * height;
  }

  /** @param {number} y */
  toOpacity(y) {
    const height = this.curve.clientHeight - 2 * EDGE;
    return fromHeight(1 - (y - EDGE) / height, element("log-opacity").checked);
  }

  changed() {
    this.showPoint();
    this.draw();
    this.handlers.changed(copy(this.transfer));
  }

  /** @param {HTMLCanvasElement} canvas @param {"colors" | "opacities"} list */
  listenTo(canvas, list) {
    let range = /** @type {number[] | null} */ (null);
    const place = (/** @type {MouseEvent} */ event) => {
      const { left, top } = canvas.getBoundingClientRect();
      return { x: event.clientX - left, y: event.clientY - top };
    };
    canvas.addEventListener("pointerdown", (event) => {
      const { x, y } = place(event);
      const index = this.caught(list, x, y, canvas);
      this.chosen = { list, index: index ?? this.addAt(list, this.toValue(x, canvas), y) };
      range = this.range;
      canvas.setPointerCapture(event.pointerId);
      canvas.focus();
      event.preventDefault();
      if (index === null) this.changed();
      else { this.showPoint(); this.draw(); }
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!range) return;
      const { x, y } = place(event);
      move(this.transfer[list], this.chosen.index, this.toValue(x, canvas));
      if (list === "opacities") this.transfer.opacities[this.chosen.index][1] = this.toOpacity(y);
      this.changed();
    });
    const up = () => {
      if (range) this.handlers.rest();
      range = null;
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("dblclick", () => this.delete());
    canvas.addEventListener("focus", () => {
      if (this.chosen.list !== list) this.chosen = { list, index: 0 };
      this.showPoint();
      this.draw();
    });
    canvas.addEventListener("keydown", (event) => this.key(event, list));
  }

  /** The point at a place. @param {"colors" | "opacities"} list @param {number} x @param {number} y @param {HTMLCanvasElement} canvas */
  caught(list, x, y, canvas) {
    let [nearest, least] = [/** @type {number | null} */ (null), CATCH];
    this.transfer[list].forEach(([value, height], index) => {
      const dy = list === "opacities" ? this.toY(/** @type {number} */ (height)) - y : 0;
      const distance = Math.hypot(this.toX(value, canvas) - x, dy);
      if (distance < least) [nearest, least] = [index, distance];
    });
    return nearest;
  }

  /** @param {"colors" | "opacities"} list @param {number} value @param {number} y */
  addAt(list, value, y) {
    if (list === "opacities") return add(this.transfer.opacities, value, this.toOpacity(y));
    return add(this.transfer.colors, value, at(this.transfer.colors, value));
  }

  delete() {
    const points = this.transfer[this.chosen.list];
    if (points.length < 2) return;
    points.splice(this.chosen.index, 1);
    this.chosen.index = clamp(this.chosen.index, 0, points.length - 1);
    this.changed();
    this.handlers.rest();
  }

  /** @param {KeyboardEvent} event @param {"colors" | "opacities"} list */
  key(event, list) {
    const points = this.transfer[list];
    const [low, high] = this.range;
    const { index } = this.chosen;
    const step = (high - low) * KEY_STEP;
    const nudge = (/** @type {number} */ dx, /** @type {number} */ dy) => {
      move(points, index, points[index][0] + dx * step);
      if (list === "opacities") {
        const log = element("log-opacity").checked;
        const point = this.transfer.opacities[index];
        point[1] = fromHeight(clamp(toHeight(point[1], log) + dy * KEY_STEP * 2, 0, 1), log);
      }
      this.changed();
      this.handlers.rest();
    };
    const choose = (/** @type {number} */ by) => {
      this.chosen.index = clamp(index + by, 0, points.length - 1);
      this.showPoint();
      this.draw();
    };
    /** @type {Record<string, () => void>} */
    const actions = event.altKey
      ? { ArrowLeft: () => nudge(-1, 0), ArrowRight: () => nudge(1, 0), ArrowUp: () => nudge(0, 1), ArrowDown: () => nudge(0, -1) }
      : {
          ArrowLeft: () => choose(-1), ArrowRight: () => choose(1), Delete: () => this.delete(), Backspace: () => this.delete(),
          Insert: () => {
            const next = points[Math.min(index + 1, points.length - 1)][0];
            const value = next > points[index][0] ? (points[index][0] + next) / 2 : points[index][0] + step;
            if (list === "colors") this.chosen.index = add(this.transfer.colors, value, at(this.transfer.colors, value));
            else this.chosen.index = add(this.transfer.opacities, value, at(this.transfer.opacities, value));
            this.changed();
            this.handlers.rest();
          },
        };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }

  listenToPoint() {
    const update = (/** @type {() => void} */ change) => () => {
      change();
      this.changed();
      this.handlers.rest();
    };
    element("point-value").addEventListener("change", update(() => {
      const value = element("point-value").valueAsNumber;
      if (Number.isFinite(value)) move(this.transfer[this.chosen.list], this.chosen.index, value);
    }));
    element("point-opacity").addEventListener("change", update(() => {
      const opacity = element("point-opacity").valueAsNumber;
      if (this.chosen.list === "opacities" && Number.isFinite(opacity)) this.transfer.opacities[this.chosen.index][1] = clamp(opacity, 0, 1);
    }));
    element("point-color").addEventListener("input", () => {
      if (this.chosen.list === "colors") this.transfer.colors[this.chosen.index][1] = fromHex(element("point-color").value);
      this.changed();
    });
    element("point-color").addEventListener("change", () => this.handlers.rest());
    element("point-delete").addEventListener("click", () => this.delete());
  }

  listenToSliders() {
    const ids = ["shift", "widen", "fade"];
    /** @type {Transfer | null} */
    let base = null;
    for (const id of ids) {
      element(id).addEventListener("input", () => {
        base ??= copy(this.transfer);
        const [shift, widen, fade] = ids.map((name) => element(name).valueAsNumber);
        const { lowest, highest } = this.histogram;
        this.transfer = adjusted(base, shift / 2, widen, fade, highest - lowest || 1);
        this.changed();
      });
      element(id).addEventListener("change", () => {
        for (const name of ids) element(name).value = "0";
        base = null;
        this.handlers.rest();
      });
    }
  }

  showPoint() {
    const { list, index } = this.chosen;
    const [value, y] = this.transfer[list][index];
    const [low, high] = this.range;
    const digits = Math.max(0, 4 - Math.floor(Math.log10(high - low)));
    element("point-value").value = String(Number(value.toFixed(Math.min(digits, 20))));
    element("point-opacity-label").hidden = list !== "opacities";
    element("point-color-label").hidden = list !== "colors";
    if (list === "opacities") element("point-opacity").value = String(Number(/** @type {number} */ (y).toPrecision(4)));
    else element("point-color").value = toHex(/** @type {number[]} */ (y));
    element("point-delete").toggleAttribute("disabled", this.transfer[list].length < 2);
  }

  draw() {
    this.drawCurve();
    this.drawColors();
  }

  /** A canvas of device pixels, cleared. @param {HTMLCanvasElement} canvas */
  prepared(canvas) {
    const ratio = devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = canvas;
    [canvas.width, canvas.height] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    return { context, width, height };
  }

  drawCurve() {
    const { context, width, height } = this.prepared(this.curve);
    if (width === 0) return;
    const style = getComputedStyle(document.documentElement);
    const color = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
    this.drawHistogram(context, height, color("--bars"));
    const { opacities } = this.transfer;
    context.beginPath();
    context.moveTo(0, this.toY(opacities[0][1]));
    // The logarithmic scale bends straight pieces.
    for (let x = 0; x <= width; x += 1) context.lineTo(x, this.toY(at(opacities, this.unbounded(x))));
    context.strokeStyle = color("--accent");
    context.lineWidth = 2;
    context.stroke();
    opacities.forEach(([value, opacity], index) => {
      const isChosen = this.chosen.list === "opacities" && this.chosen.index === index;
      context.beginPath();
      context.arc(this.toX(value, this.curve), this.toY(opacity), isChosen ? 6 : 4.5, 0, 2 * Math.PI);
      context.fillStyle = isChosen ? color("--accent") : color("--field");
      context.fill();
      context.strokeStyle = isChosen ? color("--ink") : color("--accent");
      context.stroke();
    });
  }

  /** A value beside the range too. @param {number} x */
  unbounded(x) {
    const [low, high] = this.range;
    return low + ((x - SIDE) / (this.curve.clientWidth - 2 * SIDE)) * (high - low);
  }

  /** @param {CanvasRenderingContext2D} context @param {number} height @param {string} color */
  drawHistogram(context, height, color) {
    const { lowest, highest, counts } = this.histogram;
    const scaled = (/** @type {number} */ count) => (element("log-counts").checked ? Math.log1p(count) : count);
    const most = Math.max(...counts.map(scaled), 1e-9);
    context.fillStyle = color;
    const edge = (/** @type {number} */ n) => this.toX(lowest + ((highest - lowest) * n) / counts.length, this.curve);
    // One shape: single bars would show seams.
    context.beginPath();
    context.moveTo(edge(0), height - EDGE);
    counts.forEach((count, bin) => {
      const top = height - EDGE - (scaled(count) / most) * (height - 2 * EDGE);
      context.lineTo(edge(bin), top);
      context.lineTo(edge(bin + 1), top);
    });
    context.lineTo(edge(counts.length), height - EDGE);
    context.fill();
  }

  drawColors() {
    const { context, width } = this.prepared(this.colors);
    if (width === 0) return;
    const { colors } = this.transfer;
    for (let x = 0; x < width; x += 1) {
      context.fillStyle = toHex(at(colors, this.unbounded(x)));
      context.fillRect(x, 0, 1, 18);
    }
    const ink = getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
    colors.forEach(([value, rgb], index) => {
      const x = this.toX(value, this.colors);
      const isChosen = this.chosen.list === "colors" && this.chosen.index === index;
      context.beginPath();
      context.moveTo(x, 16);
      context.lineTo(x - 6, 23);
      context.lineTo(x - 6, 32);
      context.lineTo(x + 6, 32);
      context.lineTo(x + 6, 23);
      context.closePath();
      context.fillStyle = toHex(rgb);
      context.fill();
      context.lineWidth = isChosen ? 2.5 : 1;
      context.strokeStyle = ink;
      context.stroke();
    });
  }
}
