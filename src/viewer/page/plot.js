// Scales and drawing of the transfer function's editor.

import { at, clamp, fromHeight, toHeight, toHex } from "./editing.js";

/** @typedef {import("./state.js").Transfer} Transfer */
/** @typedef {{ lowest: number, highest: number, counts: number[] }} Histogram */
/** @typedef {{ list: "colors" | "opacities", index: number, others: Set<number> }} Chosen a point, and others that are changed with it */

/** Room beside the curve in pixels, so that the outer points can be caught. */
const SIDE = 10;
/** Room above and below. */
const EDGE = 9;

const isChecked = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id)).checked;
const color = (/** @type {string} */ name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Plot {
  constructor() {
    this.curve = /** @type {HTMLCanvasElement} */ (document.getElementById("curve"));
    this.colors = /** @type {HTMLCanvasElement} */ (document.getElementById("colors"));
    /** @type {Histogram} */
    this.histogram = { lowest: 0, highest: 1, counts: [] };
    /** @type {[number, number]} */
    this.range = [0, 1];
  }

  /** The values that the curve spans: those of the data and of all points. @param {Transfer} transfer */
  fit({ colors, opacities }) {
    const { lowest, highest } = this.histogram;
    const values = [...colors, ...opacities].map(([x]) => x);
    const [low, high] = [Math.min(lowest, ...values), Math.max(highest, ...values)];
    this.range = high > low ? [low, high] : [low - 0.5, low + 0.5];
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
    return EDGE + (1 - toHeight(opacity, isChecked("log-opacity"))) * (this.curve.clientHeight - 2 * EDGE);
  }

  /** @param {number} y */
  toOpacity(y) {
    return fromHeight(1 - (y - EDGE) / (this.curve.clientHeight - 2 * EDGE), isChecked("log-opacity"));
  }

  /** @param {Transfer} transfer @param {Chosen} chosen @param {number | null} iso @param {number[] | null} box of points that are being chosen */
  draw(transfer, chosen, iso, box) {
    this.fit(transfer);
    this.drawCurve(transfer.opacities, chosen, iso, box);
    this.drawColors(transfer.colors, chosen);
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

  /** @param {[number, number][]} opacities @param {Chosen} chosen @param {number | null} iso @param {number[] | null} box */
  drawCurve(opacities, chosen, iso, box) {
    const { context, width, height } = this.prepared(this.curve);
    if (width === 0) return;
    this.drawHistogram(context, height, color("--bars"));
    context.beginPath();
    context.moveTo(0, this.toY(opacities[0][1]));
    // The logarithmic scale bends straight pieces.
    for (let x = 0; x <= width; x += 1) context.lineTo(x, this.toY(at(opacities, this.unbounded(x))));
    context.strokeStyle = color("--accent");
    context.lineWidth = 2;
    context.stroke();
    if (iso !== null) this.drawIso(context, iso, height);
    opacities.forEach(([value, opacity], index) => {
      const isChosen = chosen.list === "opacities" && (chosen.index === index || chosen.others.has(index));
      context.beginPath();
      context.arc(this.toX(value, this.curve), this.toY(opacity), isChosen ? 6 : 4.5, 0, 2 * Math.PI);
      context.fillStyle = isChosen ? color("--accent") : color("--field");
      context.fill();
      context.strokeStyle = isChosen ? color("--ink") : color("--accent");
      context.stroke();
    });
    if (box) {
      context.setLineDash([4, 3]);
      context.strokeStyle = color("--ink");
      context.lineWidth = 1;
      context.strokeRect(box[0], box[1], box[2] - box[0], box[3] - box[1]);
      context.setLineDash([]);
    }
  }

  /** @param {CanvasRenderingContext2D} context @param {number} iso @param {number} height */
  drawIso(context, iso, height) {
    const x = this.toX(iso, this.curve);
    context.strokeStyle = context.fillStyle = color("--ink");
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, 0);
    context.lineTo(x, height);
    context.stroke();
    context.font = "11px system-ui, sans-serif";
    context.textAlign = x > this.curve.clientWidth / 2 ? "right" : "left";
    context.fillText("iso", x + (x > this.curve.clientWidth / 2 ? -5 : 5), 12);
  }

  /** A value beside the range too. @param {number} x */
  unbounded(x) {
    const [low, high] = this.range;
    return low + ((x - SIDE) / (this.curve.clientWidth - 2 * SIDE)) * (high - low);
  }

  /** @param {CanvasRenderingContext2D} context @param {number} height @param {string} fill */
  drawHistogram(context, height, fill) {
    const { lowest, highest, counts } = this.histogram;
    const isLog = isChecked("log-counts");
    const scaled = (/** @type {number} */ count) => (isLog ? Math.log1p(count) : count);
    const most = Math.max(...counts.map(scaled), 1e-9);
    context.fillStyle = fill;
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

  /** @param {[number, number[]][]} colors @param {Chosen} chosen */
  drawColors(colors, chosen) {
    const { context, width } = this.prepared(this.colors);
    if (width === 0) return;
    for (let x = 0; x < width; x += 1) {
      context.fillStyle = toHex(at(colors, this.unbounded(x)));
      context.fillRect(x, 0, 1, 18);
    }
    const ink = color("--ink");
    colors.forEach(([value, rgb], index) => {
      const x = this.toX(value, this.colors);
      const isChosen = chosen.list === "colors" && (chosen.index === index || chosen.others.has(index));
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
