// Tents: triangles of opacity around a value.

import { add, at } from "./editing.js";

/** Half the width of a tent by a click, as a part of the data's range. */
export const HALF_WIDTH = 0.04;
/** Its opacity at the value. */
export const PEAK = 0.5;

/** A tent alone. @param {number} center @param {number} half @param {number} peak @returns {[number, number][]} */
export const alone = (center, half, peak) => [[center - half, 0], [center, peak], [center + half, 0]];

/** The larger of a curve and a tent. @param {[number, number][]} points @param {number} center @param {number} half @param {number} peak
 * @returns {[number, number][]} */
export function added(points, center, half, peak) {
  const tent = (/** @type {number} */ x) => peak * Math.max(0, 1 - Math.abs(x - center) / half);
  const merged = [...points];
  for (const [x] of alone(center, half, peak)) {
    if (!merged.some(([value]) => value === x)) add(merged, x, at(points, x));
  }
  /** @type {[number, number][]} */
  const larger = [];
  merged.forEach(([x, y], n) => {
    if (n > 0) {
      const [x0, y0] = merged[n - 1];
      const [a, b] = [y0 - tent(x0), y - tent(x)];
      // The curve and the tent cross.
      if (a * b < 0 && x > x0) larger.push([x0 + ((x - x0) * a) / (a - b), y0 + ((y - y0) * a) / (a - b)]);
    }
    larger.push([x, Math.max(y, tent(x))]);
  });
  return larger;
}
