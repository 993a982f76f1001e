// What the user can change: camera, look, transfer function and slices. It is a value; history and the address's fragment hold copies.

/**
 * @typedef {{ parallel_scale: number } | { perspective: [number, number] }} Projection
 * @typedef {{ azimuth: number, elevation: number, roll: number, center: number[], projection: Projection }} Camera
 * @typedef {{ direction: number[] | null, strength: number, angle: number, color?: number[] }} Light
 * @typedef {{ sky_up: number[], scattering: number, exposure: number }} Studio
 * @typedef {{ quality: string | null, kernel: string | null, blend: string, iso: number, shading: boolean, lights: Light[],
 *   lights_follow: boolean, studio: Studio | null, shadows: boolean, shadow_strength: number, ambient_occlusion: boolean, background: string,
 *   crop: number[][] | null, clips: number[][], gradient: string | null, plain: Record<string, unknown>, legend: boolean, bounding_box: boolean, axes: boolean,
 *   frame: number, channels: { visible: boolean, factor: number, color: string }[],
 *   labels: { only: string[], hidden: string[], colors: [string, string][] } }} Look
 * @typedef {{ name: string, colors: [number, number[]][], opacities: [number, number][] }} Transfer
 * @typedef {{ shown: boolean, point: number[], planes: string, colors: string, kernel: string, window: number[], thickness: number }} SlicesState
 *   `point`: of the crosshair, in the world; `window`: level and width
 * @typedef {{ camera: Camera, look: Look, transfer: Transfer, others: Transfer[], slices: SlicesState }} State `others`: of all channels but the first
 */

/** States that undo can return to. */
const MOST_STATES = 200;
/** Longest fragment: some programs cut longer addresses. */
const LONGEST_FRAGMENT = 8000;

/** @template T @param {T} value @returns {T} */
export const copy = (value) => structuredClone(value);

/** @param {unknown} a @param {unknown} b */
export const isEqual = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** The state, with undo and redo. */
export class History {
  /** @param {State} first */
  constructor(first) {
    /** @type {State} */
    this.now = copy(first);
    /** @type {State[]} */
    this.past = [copy(first)];
    this.at = 0;
  }

  /** Keeps the state if it differs from the last one. */
  commit() {
    if (isEqual(this.now, this.past[this.at])) return;
    this.past.splice(this.at + 1);
    this.past.push(copy(this.now));
    if (this.past.length > MOST_STATES) this.past.shift();
    this.at = this.past.length - 1;
  }

  /** Forgets the state, and the last one that was kept if it is the same. @returns whether there is another */
  takeBack() {
    if (isEqual(this.now, this.past[this.at])) {
      if (this.at === 0) return false;
      this.past.splice(this.at);
      this.at -= 1;
    }
    this.now = copy(this.past[this.at]);
    return true;
  }

  /** @param {number} steps −1: back, 1: forward @returns whether there was one */
  go(steps) {
    this.commit();
    const to = this.at + steps;
    if (to < 0 || to >= this.past.length) return false;
    this.at = to;
    this.now = copy(this.past[to]);
    return true;
  }
}

/** @param {State} state @param {State} initial its transfer functions are left out of the address */
export function toFragment(state, initial) {
  const { camera, look, transfer, others, slices } = state;
  const curves = { ...(isEqual(transfer, initial.transfer) ? {} : { transfer }), ...(isEqual(others, initial.others) ? {} : { others }) };
  const kept = { camera, look, ...curves, ...(slices.shown ? { slices } : {}) };
  const text = btoa(String.fromCharCode(...new TextEncoder().encode(JSON.stringify(kept))));
  const fragment = text.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  return fragment.length <= LONGEST_FRAGMENT ? fragment : null;
}

/** The state of an address's fragment; fields that it lacks or that have another shape come from `first`.
 * @param {string} fragment @param {State} first @returns {State | null} */
export function fromFragment(fragment, first) {
  if (!fragment) return null;
  try {
    const bytes = Uint8Array.from(atob(fragment.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
    const kept = JSON.parse(new TextDecoder().decode(bytes));
    const state = copy(first);
    for (const part of /** @type {const} */ (["camera", "look", "transfer", "others", "slices"])) {
      for (const name of Object.keys(state[part])) {
        if (kept[part] && name in kept[part]) /** @type {any} */ (state[part])[name] = kept[part][name];
      }
    }
    const areFields = [state.transfer, ...state.others].every(isTransfer) && state.look.channels.length === first.look.channels.length;
    return isCamera(state.camera) && areFields && isLook(state.look, first.look) && isSlices(state.slices) ? state : null;
  } catch {
    return null;
  }
}

/** @param {Camera} camera */
function isCamera({ azimuth, elevation, roll, center, projection }) {
  const numbers = [azimuth, elevation, roll, ...center, ...Object.values(projection).flat()];
  return numbers.length >= 7 && numbers.every(Number.isFinite);
}

const areNumbers = (/** @type {unknown} */ list, /** @type {number} */ count) => Array.isArray(list) && list.length === count && list.every(Number.isFinite);

/** Whether it has the shape of a look; names are known to the server. @param {any} look @param {any} first */
function isLook(look, first) {
  const isKind = (/** @type {string} */ name) => typeof look[name] === typeof first[name] && Array.isArray(look[name]) === Array.isArray(first[name]);
  const isText = (/** @type {unknown} */ value) => typeof value === "string";
  const { quality, kernel, gradient, lights, studio, crop, clips, channels, labels } = look;
  return Object.keys(first).filter((name) => !["quality", "kernel", "gradient", "crop", "studio"].includes(name)).every(isKind)
    && [quality, kernel, gradient].every((name) => name === null || isText(name))
    && lights.every((/** @type {any} */ { direction, strength, angle, color }) => (direction === null || areNumbers(direction, 3))
      && areNumbers([strength, angle], 2) && (color === undefined || areNumbers(color, 3)))
    && (studio === null || (areNumbers(studio.sky_up, 3) && areNumbers([studio.scattering, studio.exposure], 2)))
    && (crop === null || (crop.length === 2 && crop.every((/** @type {unknown} */ corner) => areNumbers(corner, 3))))
    && clips.every((/** @type {unknown} */ clip) => areNumbers(clip, 6))
    && channels.every((/** @type {any} */ { visible, factor, color }) => typeof visible === "boolean" && Number.isFinite(factor) && isText(color))
    && [...labels.only, ...labels.hidden, ...labels.colors.flat()].every(isText);
}

/** @param {SlicesState} slices */
function isSlices({ point, window, thickness, planes, colors, kernel }) {
  const isOne = (/** @type {string} */ name, /** @type {string[]} */ all) => all.includes(name);
  return point.length === 3 && window.length === 2 && [...point, ...window, thickness].every(Number.isFinite) && window[1] > 0
    && thickness > 0 && isOne(planes, ["axes", "camera"]) && isOne(colors, ["window", "colors", "opacity"])
    && isOne(kernel, ["linear", "cubic", "catmull-rom", "bspline"]);
}

/** @param {Transfer} transfer */
function isTransfer({ colors, opacities }) {
  const isColor = (/** @type {any} */ p) => Number.isFinite(p[0]) && p[1].length === 3 && p[1].every(Number.isFinite);
  const isOpacity = (/** @type {any} */ p) => p.length === 2 && p.every(Number.isFinite);
  return colors.length > 0 && opacities.length > 0 && colors.every(isColor) && opacities.every(isOpacity);
}
