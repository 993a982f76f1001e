// Changes of transfer functions, without a page around them.

/** @typedef {import("./state.js").Transfer} Transfer */

/** @param {number} x @param {number} low @param {number} high */
export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** Value of a piecewise linear function of numbers or of colours. @template {number | number[]} T
 * @param {[number, T][]} points @param {number} value @returns {T} */
export function at(points, value) {
  const next = points.findIndex(([x]) => x > value);
  if (next === 0) return points[0][1];
  if (next < 0) return points[points.length - 1][1];
  const [[x0, y0], [x1, y1]] = [points[next - 1], points[next]];
  const t = (value - x0) / (x1 - x0);
  const mix = (/** @type {number} */ a, /** @type {number} */ b) => a + (b - a) * t;
  if (typeof y0 === "number") return /** @type {T} */ (mix(y0, /** @type {number} */ (y1)));
  return /** @type {T} */ (y0.map((c, i) => mix(c, /** @type {number[]} */ (y1)[i])));
}

/** Adds a point; returns its index. @template T @param {[number, T][]} points @param {number} value @param {T} y */
export function add(points, value, y) {
  const next = points.findIndex(([x]) => x > value);
  const index = next < 0 ? points.length : next;
  points.splice(index, 0, [value, y]);
  return index;
}

/** Moves points by the same way, as far as the neighbours of all of them allow. @param {[number, unknown][]} points
 * @param {number[]} indices in order @param {number} by */
export function moveAll(points, indices, by) {
  const isMoved = (/** @type {number} */ n) => indices.includes(n);
  const rooms = indices.map((n) => {
    const low = n > 0 && !isMoved(n - 1) ? points[n - 1][0] : -Infinity;
    const high = n + 1 < points.length && !isMoved(n + 1) ? points[n + 1][0] : Infinity;
    return [low - points[n][0], high - points[n][0]];
  });
  const way = clamp(by, Math.max(...rooms.map(([low]) => low)), Math.min(...rooms.map(([, high]) => high)));
  for (const n of indices) points[n][0] += way;
}

/** Mirrors points about a value, by default the middle of theirs. @template T @param {[number, T][]} points
 * @param {number[]} indices in order @param {number} [middle] @returns {[number, T][]} */
export function flipped(points, indices, middle) {
  const values = indices.map((n) => points[n][0]);
  const twice = middle === undefined ? Math.min(...values) + Math.max(...values) : 2 * middle;
  const mirrored = indices.map((n) => /** @type {[number, T]} */ ([twice - points[n][0], points[n][1]]));
  const others = points.filter((_, n) => !indices.includes(n));
  return [...others, ...mirrored.reverse()].sort((a, b) => a[0] - b[0]);
}

/** Shifts, widens and fades all points of a function. `shift` −1 … 1 is a range's width, `widen` −1 … 1 a factor of 1/4 … 4 about the middle,
 * `fade` −1 … 1 a factor of 0 … 1, or of up to ten times the optical depth.
 * @param {Transfer} transfer @param {number} shift @param {number} widen @param {number} fade @param {number} width of the data's range */
export function adjusted({ name, colors, opacities }, shift, widen, fade, width) {
  const values = opacities.map(([x]) => x);
  const middle = (Math.min(...values) + Math.max(...values)) / 2;
  const moved = (/** @type {number} */ x) => middle + (x - middle) * 4 ** widen + shift * width;
  const faded = (/** @type {number} */ a) => (fade <= 0 ? a * (1 + fade) : 1 - (1 - a) ** (10 ** fade));
  return /** @type {Transfer} */ ({
    name,
    colors: colors.map(([x, c]) => [moved(x), [...c]]),
    opacities: opacities.map(([x, a]) => [moved(x), clamp(faded(a), 0, 1)]),
  });
}

/** Opacity as a height of the curve, 0 … 1. The logarithmic scale spans three decades. @param {number} opacity @param {boolean} log */
export const toHeight = (opacity, log) => (log ? clamp(1 + Math.log10(Math.max(opacity, 1e-9)) / 3, 0, 1) : opacity);
/** @param {number} height @param {boolean} log */
export const fromHeight = (height, log) => (log ? (height <= 0 ? 0 : 10 ** (3 * (height - 1))) : clamp(height, 0, 1));

/** @param {number[]} rgb 0 … 1 */
export const toHex = (rgb) => `#${rgb.map((c) => Math.round(clamp(c, 0, 1) * 255).toString(16).padStart(2, "0")).join("")}`;
/** @param {string} hex */
export const fromHex = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
