// Handles in the picture: faces of the crop box, and clip planes.

import { dot, projected, sum, times, unit, worldAxes } from "./camera.js";

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {{ kind: "face", axis: number, end: number, point: number[] } | { kind: "plane", index: number, point: number[] } |
 *   { kind: "flip", index: number, point: number[] }} Handle */

/** Pixels within which a handle is caught. */
const CATCH = 14;
/** Part of the volume's diagonal: half the side of a plane's square, and the length of its arrow. */
const SQUARE = 0.17;
const ARROW = 0.14;
/** Part of the picture, from its middle, in which all handles are when they are switched on. */
const REACH = 0.86;
/** Least part of a direction that is seen from the side: others are dragged up and down. */
const STEEP = 0.25;
/** Edges of a box by its corners: these differ in one bit. */
const EDGES = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((a) => [1, 2, 4].filter((bit) => !(a & bit)).map((bit) => [a, a | bit]));

export class Handles {
  /** @param {Session} session @param {import("./cutting.js").Cutting} cutting */
  constructor(session, cutting) {
    this.session = session;
    this.cutting = cutting;
    this.shown = /** @type {HTMLInputElement} */ (document.getElementById("handles"));
  }

  get isShown() {
    return this.shown.checked && this.session.history !== null;
  }

  get look() {
    return this.session.state.look;
  }

  /** @param {number[]} voxel */
  toWorld(voxel) {
    const { origin, spacing, direction } = this.session.hello.volume;
    return [0, 1, 2].map((i) => origin[i] + [0, 1, 2].reduce((total, axis) => total + direction[3 * axis + i] * spacing[axis] * voxel[axis], 0));
  }

  /** The way of one voxel along an axis in the world. @param {number} axis */
  step(axis) {
    const { spacing, direction } = this.session.hello.volume;
    return [0, 1, 2].map((i) => direction[3 * axis + i] * spacing[axis]);
  }

  get box() {
    return this.look.crop ?? this.cutting.whole;
  }

  /** @returns {Handle[]} */
  get all() {
    const [lowest, highest] = this.box;
    const middle = lowest.map((low, i) => (low + highest[i]) / 2);
    const faces = [0, 1, 2].flatMap((axis) => [0, 1].map((end) => {
      const at = middle.map((x, i) => (i === axis ? this.box[end][i] : x));
      return /** @type {Handle} */ ({ kind: "face", axis, end, point: this.toWorld(at) });
    }));
    const planes = this.look.clips.flatMap((clip, index) => /** @type {Handle[]} */ ([
      { kind: "plane", index, point: clip.slice(0, 3) },
      { kind: "flip", index, point: this.tip(clip) },
    ]));
    return [...planes, ...faces];
  }

  /** End of the arrow of a plane, on its visible side. @param {number[]} clip */
  tip(clip) {
    return sum(clip.slice(0, 3), times(unit(clip.slice(3)), ARROW * this.session.hello.volume.diagonal));
  }

  /** @param {number[]} point */
  place(point) {
    return projected(point, this.session.state.camera, this.session.hello.frame);
  }

  /** How many times too near the view is for all handles to be in the picture. @param {number} aspect of the picture */
  beyond(aspect) {
    if (!this.isShown) return 1;
    const places = this.all.map(({ point }) => this.place(point));
    return Math.max(...places.map(({ x, y, scale }) => (scale > 0 ? Math.max(Math.abs(y), Math.abs(x) / aspect) / REACH : 2)));
  }

  /** Takes the handle at a place. @param {Place} from @param {number} pixel half heights per pixel */
  grab(from, pixel) {
    if (!this.isShown) return null;
    const near = this.all.map((handle) => ({ handle, at: this.place(handle.point) }))
      .map(({ handle, at }) => ({ handle, far: Math.hypot(at.x - from.x, at.y - from.y) / pixel, scale: at.scale }))
      .filter(({ far, scale }) => far < CATCH && scale > 0).sort((a, b) => a.far - b.far)[0];
    return near ? this.dragOf(near.handle, from) : null;
  }

  /** @param {Handle} handle @param {Place} from */
  dragOf(handle, from) {
    const { session } = this;
    const rest = { move: () => {}, end: () => session.settle() };
    if (handle.kind === "flip") {
      session.changeLook((look) => look.clips[handle.index].splice(3, 3, ...look.clips[handle.index].slice(3).map((x) => (x === 0 ? 0 : -x))), false);
      return rest;
    }
    if (handle.kind === "face") {
      const start = this.box[handle.end][handle.axis];
      const along = this.alongScreen(handle.point, this.step(handle.axis));
      return {
        move: (/** @type {Place} */ to) => this.cutting.cropTo(handle.axis, handle.end, start + this.way(along, from, to), false),
        end: rest.end,
      };
    }
    const start = this.look.clips[handle.index].slice(0, 3);
    const normal = unit(this.look.clips[handle.index].slice(3));
    const along = this.alongScreen(start, normal);
    return {
      move: (/** @type {Place} */ to) => session.changeLook((look) => {
        look.clips[handle.index].splice(0, 3, ...sum(start, times(normal, this.way(along, from, to))));
      }, false),
      end: rest.end,
    };
  }

  /** How a step in the world moves on the screen, in half heights. Steps towards the viewer are dragged upwards.
   * @param {number[]} point @param {number[]} step */
  alongScreen(point, step) {
    const { right, up } = worldAxes(this.session.state.camera, this.session.hello.frame);
    const { scale } = this.place(point);
    const [x, y] = [dot(step, right) * scale, dot(step, up) * scale];
    const whole = Math.hypot(...step) * scale;
    return Math.hypot(x, y) < STEEP * whole ? { x: 0, y: whole } : { x, y };
  }

  /** Steps that a movement of the hand is. @param {{ x: number, y: number }} along @param {Place} from @param {Place} to */
  way(along, from, to) {
    return ((to.x - from.x) * along.x + (to.y - from.y) * along.y) / (along.x ** 2 + along.y ** 2 || 1);
  }

  /** @param {import("./overlay.js").Overlay} overlay */
  paint(overlay) {
    if (!this.isShown) return;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => this.place(this.toWorld([0, 1, 2].map((axis) => this.box[(n >> axis) & 1][axis]))));
    for (const [a, b] of EDGES) if (corners[a].scale > 0 && corners[b].scale > 0) overlay.line([corners[a], corners[b]], "#8fd3ff");
    for (const clip of this.look.clips) this.paintPlane(overlay, clip);
    for (const handle of this.all) {
      const at = this.place(handle.point);
      if (at.scale > 0) overlay.dot(at, { face: "#8fd3ff", plane: "#ffb86b", flip: "#ffffff" }[handle.kind], handle.kind === "flip" ? 5 : 7);
    }
  }

  /** @param {import("./overlay.js").Overlay} overlay @param {number[]} clip */
  paintPlane(overlay, clip) {
    const [point, normal] = [clip.slice(0, 3), unit(clip.slice(3))];
    const least = normal.map(Math.abs).indexOf(Math.min(...normal.map(Math.abs)));
    const other = [0, 1, 2].map((i) => (i === least ? 1 : 0));
    const side = unit(sum(other, times(normal, -dot(other, normal))));
    const across = [normal[1] * side[2] - normal[2] * side[1], normal[2] * side[0] - normal[0] * side[2], normal[0] * side[1] - normal[1] * side[0]];
    const half = SQUARE * this.session.hello.volume.diagonal;
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => this.place(sum(point, times(side, a * half), times(across, b * half))));
    if (corners.every(({ scale }) => scale > 0)) overlay.line(corners, "#ffb86b", true);
    overlay.line([this.place(point), this.place(this.tip(clip))], "#ffb86b");
  }
}
