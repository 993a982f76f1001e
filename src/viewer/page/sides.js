// The orientation cube, and buttons of the six sides.

import { axes, dot } from "./camera.js";

/** @typedef {{ name: string, seen_from: string, azimuth: number, elevation: number }} Side */
/** @typedef {{ azimuth: number, elevation: number }} Direction */

/** Half an edge of the cube, relative to the canvas. */
const HALF = 0.27;
/** Distance from a corner within which it is chosen, relative to half the canvas. */
const CORNER = 0.16;
/** Elevation of a corner in degrees: its three faces look alike. */
export const CORNER_ELEVATION = (Math.atan(Math.SQRT1_2) * 180) / Math.PI;

export class Sides {
  /** @param {(side: Direction) => void} choose */
  constructor(choose) {
    this.choose = choose;
    this.canvas = /** @type {HTMLCanvasElement} */ (document.getElementById("cube"));
    /** @type {Side[]} */
    this.sides = [];
    /** Faces of the last drawing, by centre. @type {{ side: Side, x: number, y: number, towards: number }[]} */
    this.faces = [];
    /** Corners of the last drawing. @type {(Direction & { x: number, y: number, towards: number })[]} */
    this.corners = [];
    this.canvas.addEventListener("click", (event) => {
      const { left, top, width, height } = this.canvas.getBoundingClientRect();
      const [x, y] = [((event.clientX - left) / width) * 2 - 1, 1 - ((event.clientY - top) / height) * 2];
      const visible = this.faces.filter((face) => face.towards > 0.05);
      const corner = this.corners.find((at) => at.towards > 0 && Math.hypot(at.x - x, at.y - y) < CORNER);
      if (corner) return choose(corner);
      const nearest = visible.sort((a, b) => Math.hypot(a.x - x, a.y - y) - Math.hypot(b.x - x, b.y - y))[0];
      if (nearest) choose(nearest.side);
    });
  }

  /** @param {Side[]} sides */
  set(sides) {
    this.sides = sides;
    const group = /** @type {HTMLElement} */ (document.getElementById("sides"));
    group.replaceChildren(...sides.map((side, n) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = `${side.name} ${side.seen_from}`;
      button.title = `${side.name} (${n + 1})`;
      button.addEventListener("click", () => this.choose(side));
      return button;
    }));
  }

  /** @param {import("./state.js").Camera} camera */
  draw(camera) {
    const { canvas, sides } = this;
    const ratio = devicePixelRatio || 1;
    const size = Math.round(canvas.clientWidth * ratio);
    [canvas.width, canvas.height] = [size, size];
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const own = axes(camera);
    /** On the screen, in half widths of the canvas; the third is towards the viewer. @param {number[]} v */
    const seen = (v) => [dot(v, own.right) * 2 * HALF, dot(v, own.up) * 2 * HALF, dot(v, own.toEye)];
    const toPixels = (/** @type {number[]} */ [x, y]) => [((x + 1) / 2) * size, ((1 - y) / 2) * size];
    this.faces = sides.map((side) => {
      const { toEye: normal, right, up } = axes({ ...camera, azimuth: side.azimuth, elevation: side.elevation, roll: 0 });
      const [x, y, towards] = seen(normal);
      const corner = (/** @type {number} */ a, /** @type {number} */ b) => seen(normal.map((n, i) => n + a * right[i] + b * up[i]));
      return { side, x, y, towards, corners: [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)] };
    }).sort((a, b) => a.towards - b.towards);
    this.corners = [45, 135, 225, 315].flatMap((azimuth) => [CORNER_ELEVATION, -CORNER_ELEVATION].map((elevation) => {
      const [x, y, towards] = seen(axes({ ...camera, azimuth, elevation, roll: 0 }).toEye.map((n) => n * Math.sqrt(3)));
      return { azimuth, elevation, x, y, towards };
    }));
    const style = getComputedStyle(document.documentElement);
    const color = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const face of /** @type {(typeof this.faces[0] & { corners: number[][] })[]} */ (this.faces)) {
      if (face.towards <= 0) continue;
      context.beginPath();
      face.corners.map(toPixels).forEach(([x, y], n) => (n === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
      context.closePath();
      context.globalAlpha = 0.92;
      context.fillStyle = color("--field");
      context.fill();
      context.globalAlpha = 1;
      context.lineWidth = 1.2 * ratio;
      context.strokeStyle = color("--soft");
      context.stroke();
      if (face.towards < 0.25) continue;
      const [x, y] = toPixels([face.x, face.y]);
      context.fillStyle = color("--ink");
      context.font = `600 ${Math.round(size * 0.15 * Math.min(1, 0.5 + face.towards / 2))}px system-ui, sans-serif`;
      context.fillText(face.side.seen_from, x, y);
    }
    context.fillStyle = color("--accent");
    for (const corner of this.corners.filter(({ towards }) => towards > 0)) {
      const [x, y] = toPixels([corner.x, corner.y]);
      context.beginPath();
      context.arc(x, y, 3 * ratio, 0, 2 * Math.PI);
      context.fill();
    }
  }
}
