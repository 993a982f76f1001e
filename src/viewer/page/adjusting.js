// Sliders that change a whole transfer function: its range, and shift, widen, fade.

import { adjusted, clamp } from "./editing.js";
import { copy } from "./state.js";

/** @typedef {import("./state.js").Transfer} Transfer */
/** @typedef {import("./plot.js").Histogram} Histogram */

const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

/** Part of the data's voxels below a value, in percent. @param {Histogram} histogram @param {number} value */
export function percentileOf({ lowest, highest, counts }, value) {
  const place = highest > lowest ? clamp((value - lowest) / (highest - lowest), 0, 1) * counts.length : 0;
  const bin = Math.min(Math.floor(place), counts.length - 1);
  const total = counts.reduce((sum, count) => sum + count, 0) || 1;
  const below = counts.slice(0, bin).reduce((sum, count) => sum + count, 0);
  return (100 * (below + counts[bin] * (place - bin))) / total;
}

/** The value of a percentile. @param {Histogram} histogram @param {number} percent */
export function valueOf({ lowest, highest, counts }, percent) {
  const total = counts.reduce((sum, count) => sum + count, 0);
  let left = (clamp(percent, 0, 100) / 100) * total;
  for (const [bin, count] of counts.entries()) {
    if (left <= count && count > 0) return lowest + ((highest - lowest) * (bin + left / count)) / counts.length;
    left -= count;
  }
  return highest;
}

/** The range of a transfer function's points. @param {Transfer} transfer */
export function ends({ colors, opacities }) {
  const values = [...colors, ...opacities].map(([x]) => x);
  return [Math.min(...values), Math.max(...values)];
}

/** Stretches all points to another range. @param {Transfer} transfer @param {number[]} to @returns {Transfer} */
export function stretched({ name, colors, opacities }, [low, high]) {
  const [from, end] = ends({ name, colors, opacities });
  const moved = (/** @type {number} */ x) => low + ((x - from) / (end - from)) * (high - low);
  return { name, colors: colors.map(([x, c]) => [moved(x), c]), opacities: opacities.map(([x, a]) => [moved(x), a]) };
}

export class Adjusting {
  /** @param {{ transfer: () => Transfer, histogram: () => Histogram, change: (transfer: Transfer) => void, rest: () => void }} editor */
  constructor(editor) {
    this.editor = editor;
    this.listenToSliders();
    this.listenToRange();
  }

  listenToSliders() {
    const { editor } = this;
    const ids = ["shift", "widen", "fade"];
    /** @type {Transfer | null} */
    let base = null;
    for (const id of ids) {
      field(id).addEventListener("input", () => {
        base ??= copy(editor.transfer());
        const [shift, widen, fade] = ids.map((name) => field(name).valueAsNumber);
        const { lowest, highest } = editor.histogram();
        editor.change(adjusted(base, shift / 2, widen, fade, highest - lowest || 1));
      });
      field(id).addEventListener("change", () => {
        for (const name of ids) field(name).value = "0";
        base = null;
        editor.rest();
      });
    }
  }

  /** Handles of the range: sliders, values and percentiles. */
  listenToRange() {
    const { editor } = this;
    ["low", "high"].forEach((name, end) => {
      const set = (/** @type {number} */ value, /** @type {boolean} */ isDone) => {
        const range = ends(editor.transfer());
        const { lowest, highest } = editor.histogram();
        // The ends do not meet.
        const gap = (highest - lowest) / 1000 || 1e-9;
        range[end] = end === 0 ? Math.min(value, range[1] - gap) : Math.max(value, range[0] + gap);
        if (Number.isFinite(value)) editor.change(stretched(editor.transfer(), range));
        if (isDone) editor.rest();
      };
      const slider = field(`range-${name}`);
      slider.addEventListener("input", () => set(slider.valueAsNumber, false));
      slider.addEventListener("change", () => set(slider.valueAsNumber, true));
      field(`range-${name}-value`).addEventListener("change", () => set(field(`range-${name}-value`).valueAsNumber, true));
      const percentile = field(`range-${name}-percentile`);
      percentile.addEventListener("change", () => set(valueOf(editor.histogram(), percentile.valueAsNumber), true));
    });
  }

  /** @param {Transfer} transfer @param {[number, number]} range of the sliders */
  show(transfer, range) {
    const histogram = this.editor.histogram();
    const values = ends(transfer);
    ["low", "high"].forEach((name, end) => {
      const [slider, value, percentile] = ["", "-value", "-percentile"].map((part) => field(`range-${name}${part}`));
      [slider.min, slider.max] = range.map(String);
      slider.value = String(values[end]);
      if (value !== document.activeElement) value.value = String(Number(values[end].toPrecision(6)));
      if (percentile !== document.activeElement) percentile.value = String(Number(percentileOf(histogram, values[end]).toFixed(2)));
      for (const input of [slider, value, percentile]) input.disabled = values[0] === values[1];
    });
  }
}
