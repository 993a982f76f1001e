// The editor of the transfer function: a curve over the histogram, and the colours below.

import { Adjusting } from "./adjusting.js";
import { add, at, clamp, flipped, fromHeight, fromHex, moveAll, toHeight, toHex } from "./editing.js";
import { keyed } from "./editor-keys.js";
import { Plot } from "./plot.js";
import { copy, isEqual } from "./state.js";
import * as tents from "./tents.js";

/** @typedef {import("./state.js").Transfer} Transfer */
/** @typedef {"colors" | "opacities"} List */
/** @typedef {{ kind: "points" | "box" | "tent" | "iso", from: { x: number, y: number }, base: Transfer }} Drag */

/** Pixels within which a point is caught. */
const CATCH = 12;
/** Pixels within which the iso-value is caught. */
const CATCH_ISO = 6;

/** @param {string} id */
const element = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

export class Editor {
  /** @param {{ changed: (transfer: Transfer) => void, rest: () => void, iso: (value: number, isDone: boolean) => void,
   *   isTent: () => boolean }} handlers `isTent`: whether drags make tents */
  constructor(handlers) {
    this.handlers = handlers;
    this.plot = new Plot();
    /** @type {Transfer} */
    this.transfer = { name: "", colors: [[0, [1, 1, 1]]], opacities: [[0, 0]] };
    /** @type {import("./plot.js").Chosen} */
    this.chosen = { list: "opacities", index: 0, others: new Set() };
    /** The iso-value, where it is shown. @type {number | null} */
    this.iso = null;
    /** @type {number[] | null} */
    this.box = null;
    this.adjusting = new Adjusting({
      transfer: () => this.transfer, histogram: () => this.plot.histogram,
      change: (transfer) => this.change(transfer), rest: () => handlers.rest(),
    });
    this.listenTo(this.plot.curve, "opacities");
    this.listenTo(this.plot.colors, "colors");
    this.listenToPoint();
    for (const id of ["log-counts", "log-opacity"]) element(id).addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.plot.curve);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  /** @param {import("./plot.js").Histogram} histogram */
  setHistogram(histogram) {
    this.plot.histogram = histogram;
  }

  /** Shows a transfer function that was changed elsewhere. @param {Transfer} transfer */
  set(transfer) {
    // Chosen points stay chosen.
    if (isEqual(transfer, this.transfer)) return this.draw();
    this.transfer = copy(transfer);
    this.choose(this.chosen.list, clamp(this.chosen.index, 0, this.transfer[this.chosen.list].length - 1));
  }

  /** Shows the iso-value, or hides it. @param {number | null} iso */
  setIso(iso) {
    this.iso = iso;
    this.draw();
  }

  /** @param {List} list @param {number} index @param {Set<number>} [others] */
  choose(list, index, others = new Set()) {
    this.chosen = { list, index, others };
    this.showPoint();
    this.draw();
  }

  /** All chosen points in order. */
  get indices() {
    return [...new Set([this.chosen.index, ...this.chosen.others])].sort((a, b) => a - b);
  }

  /** @param {Transfer} transfer */
  change(transfer) {
    this.transfer = transfer;
    this.showPoint();
    this.draw();
    this.handlers.changed(copy(transfer));
  }

  changed() {
    this.change(this.transfer);
  }

  /** Shows what has about this value. @param {number} value @param {boolean} isAlone whether the rest is hidden */
  showAround(value, isAlone) {
    const { lowest, highest } = this.plot.histogram;
    this.addTent(this.transfer, value, (highest - lowest) * tents.HALF_WIDTH || 0.5, tents.PEAK, isAlone);
    this.handlers.rest();
  }

  /** @param {Transfer} base @param {number} center @param {number} half @param {number} peak @param {boolean} isAlone */
  addTent(base, center, half, peak, isAlone) {
    const opacities = isAlone ? tents.alone(center, half, peak) : tents.added(base.opacities, center, half, peak);
    this.chosen = { list: "opacities", index: opacities.findIndex(([x]) => x === center), others: new Set() };
    this.change({ ...base, opacities });
  }

  /** @param {HTMLCanvasElement} canvas @param {List} list */
  listenTo(canvas, list) {
    /** @type {Drag | null} */
    let drag = null;
    const place = (/** @type {MouseEvent} */ event) => {
      const { left, top } = canvas.getBoundingClientRect();
      return { x: event.clientX - left, y: event.clientY - top };
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      canvas.focus();
      event.preventDefault();
      drag = this.begin(list, place(event), event.shiftKey, canvas);
    });
    canvas.addEventListener("pointermove", (event) => { if (drag) this.drag(drag, list, place(event), canvas); });
    const up = () => {
      if (drag?.kind === "iso" && this.iso !== null) this.handlers.iso(this.iso, true);
      else if (drag && drag.kind !== "box") this.handlers.rest();
      drag = this.box = null;
      this.draw();
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("dblclick", (event) => {
      const { x, y } = place(event);
      if (!event.shiftKey && !this.handlers.isTent() && this.caught(list, x, y, canvas) !== null) this.delete();
    });
    canvas.addEventListener("focus", () => { if (this.chosen.list !== list) this.choose(list, 0); });
    canvas.addEventListener("keydown", (event) => keyed(this, event, list));
  }

  /** What a press begins. @param {List} list @param {{ x: number, y: number }} from @param {boolean} isMore whether points are added to the chosen ones
   * @param {HTMLCanvasElement} canvas @returns {Drag | null} */
  begin(list, from, isMore, canvas) {
    const base = copy(this.transfer);
    const { x, y } = from;
    if (list === "opacities" && this.handlers.isTent()) return { kind: "tent", from, base };
    const index = this.caught(list, x, y, canvas);
    if (isMore) {
      if (index === null) return { kind: "box", from, base };
      const others = new Set(this.chosen.list === list ? this.indices : []);
      if (others.has(index) && others.size > 1) others.delete(index);
      else others.add(index);
      this.choose(list, [...others][0], others);
      return null;
    }
    if (index === null && list === "opacities" && this.iso !== null && Math.abs(this.plot.toX(this.iso, canvas) - x) < CATCH_ISO) {
      return { kind: "iso", from, base };
    }
    if (index === null) {
      this.choose(list, this.addAt(list, this.plot.toValue(x, canvas), y));
      this.changed();
    } else if (this.chosen.list !== list || !this.chosen.others.has(index)) {
      this.choose(list, index);
    }
    return { kind: "points", from, base: copy(this.transfer) };
  }

  /** @param {Drag} drag @param {List} list @param {{ x: number, y: number }} to @param {HTMLCanvasElement} canvas */
  drag({ kind, from, base }, list, to, canvas) {
    const { plot } = this;
    const value = plot.toValue(to.x, canvas);
    if (kind === "iso") {
      this.setIso(value);
      this.handlers.iso(value, false);
    } else if (kind === "tent") {
      const center = plot.toValue(from.x, canvas);
      const [low, high] = plot.range;
      const half = Math.max(Math.abs(value - center), (high - low) / 200);
      this.addTent(base, center, half, plot.toOpacity(to.y), element("tent-alone").checked);
    } else if (kind === "box") {
      this.box = [Math.min(from.x, to.x), Math.min(from.y, to.y), Math.max(from.x, to.x), Math.max(from.y, to.y)];
      this.chooseWithin(list, this.box, canvas);
    } else {
      const by = value - plot.toValue(from.x, canvas);
      const points = copy(base[list]);
      // One point is at the cursor; several move by the same way.
      const only = this.indices.length === 1 ? this.chosen.index : null;
      moveAll(points, this.indices, only === null ? by : value - points[only][0]);
      if (list === "opacities") {
        const isLog = element("log-opacity").checked;
        const rise = toHeight(plot.toOpacity(to.y), isLog) - toHeight(plot.toOpacity(from.y), isLog);
        for (const index of this.indices) {
          const point = /** @type {[number, number]} */ (points[index]);
          point[1] = only === null ? fromHeight(clamp(toHeight(point[1], isLog) + rise, 0, 1), isLog) : plot.toOpacity(to.y);
        }
      }
      this.change({ ...this.transfer, [list]: points });
    }
  }

  /** @param {List} list @param {number[]} box @param {HTMLCanvasElement} canvas */
  chooseWithin(list, [left, top, right, bottom], canvas) {
    const isWithin = (/** @type {[number, unknown]} */ [value, y]) => {
      const x = this.plot.toX(value, canvas);
      const height = list === "opacities" ? this.plot.toY(/** @type {number} */ (y)) : top;
      return x >= left && x <= right && height >= top && height <= bottom;
    };
    const within = this.transfer[list].flatMap((point, index) => (isWithin(/** @type {[number, unknown]} */ (point)) ? [index] : []));
    if (within.length > 0) this.choose(list, within[0], new Set(within));
    else this.draw();
  }

  /** The point at a place. @param {List} list @param {number} x @param {number} y @param {HTMLCanvasElement} canvas */
  caught(list, x, y, canvas) {
    let [nearest, least] = [/** @type {number | null} */ (null), CATCH];
    this.transfer[list].forEach(([value, height], index) => {
      const dy = list === "opacities" ? this.plot.toY(/** @type {number} */ (height)) - y : 0;
      const distance = Math.hypot(this.plot.toX(value, canvas) - x, dy);
      if (distance < least) [nearest, least] = [index, distance];
    });
    return nearest;
  }

  /** @param {List} list @param {number} value @param {number} y */
  addAt(list, value, y) {
    if (list === "opacities") return add(this.transfer.opacities, value, this.plot.toOpacity(y));
    return add(this.transfer.colors, value, at(this.transfer.colors, value));
  }

  /** Deletes the chosen points; one stays. */
  delete() {
    const points = /** @type {unknown[]} */ (this.transfer[this.chosen.list]);
    if (points.length < 2) return;
    const gone = this.indices.slice(0, points.length - 1);
    gone.reverse().forEach((index) => points.splice(index, 1));
    this.chosen = { ...this.chosen, index: clamp(this.chosen.index, 0, points.length - 1), others: new Set() };
    this.changed();
    this.handlers.rest();
  }

  /** Mirrors the chosen points about the middle of their values, or the whole transfer function if one is chosen. */
  flip() {
    const { list } = this.chosen;
    const { colors, opacities } = this.transfer;
    if (this.indices.length > 1) {
      const mirrored = list === "colors" ? { colors: flipped(colors, this.indices) } : { opacities: flipped(opacities, this.indices) };
      this.change({ ...this.transfer, ...mirrored });
    } else {
      const all = (/** @type {unknown[]} */ points) => points.map((_, index) => index);
      const values = [...colors, ...opacities].map(([x]) => x);
      const middle = (Math.min(...values) + Math.max(...values)) / 2;
      this.change({ ...this.transfer, colors: flipped(colors, all(colors), middle), opacities: flipped(opacities, all(opacities), middle) });
    }
    this.handlers.rest();
  }

  listenToPoint() {
    const update = (/** @type {() => void} */ change) => () => {
      change();
      this.changed();
      this.handlers.rest();
    };
    element("point-value").addEventListener("change", update(() => {
      const points = this.transfer[this.chosen.list];
      const value = element("point-value").valueAsNumber;
      if (Number.isFinite(value)) moveAll(points, [this.chosen.index], value - points[this.chosen.index][0]);
    }));
    element("point-opacity").addEventListener("change", update(() => {
      const opacity = element("point-opacity").valueAsNumber;
      if (this.chosen.list !== "opacities" || !Number.isFinite(opacity)) return;
      for (const index of this.indices) this.transfer.opacities[index][1] = clamp(opacity, 0, 1);
    }));
    element("point-color").addEventListener("input", () => {
      const color = fromHex(element("point-color").value);
      if (this.chosen.list === "colors") for (const index of this.indices) this.transfer.colors[index][1] = [...color];
      this.changed();
    });
    element("point-color").addEventListener("change", () => this.handlers.rest());
    element("point-delete").addEventListener("click", () => this.delete());
    element("flip").addEventListener("click", () => this.flip());
  }

  showPoint() {
    const { list, index } = this.chosen;
    const [value, y] = this.transfer[list][index];
    this.plot.fit(this.transfer);
    const [low, high] = this.plot.range;
    const digits = Math.max(0, 4 - Math.floor(Math.log10(high - low)));
    element("point-value").value = String(Number(value.toFixed(Math.min(digits, 20))));
    element("point-opacity-label").hidden = list !== "opacities";
    element("point-color-label").hidden = list !== "colors";
    if (list === "opacities") element("point-opacity").value = String(Number(/** @type {number} */ (y).toPrecision(4)));
    else element("point-color").value = toHex(/** @type {number[]} */ (y));
    element("point-delete").toggleAttribute("disabled", this.transfer[list].length < 2);
    this.adjusting.show(this.transfer, this.plot.range);
  }

  draw() {
    this.plot.draw(this.transfer, this.chosen, this.iso, this.box);
  }
}
