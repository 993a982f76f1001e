// Keys on the curve and on the colours.

import { add, at, clamp, fromHeight, moveAll, toHeight } from "./editing.js";

/** Part of the range that a key moves a point by. */
const KEY_STEP = 1 / 100;

const isChecked = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id)).checked;

/** @param {import("./editor.js").Editor} editor @param {KeyboardEvent} event @param {import("./editor.js").List} list */
export function keyed(editor, event, list) {
  const { colors, opacities } = editor.transfer;
  const points = editor.transfer[list];
  const { index } = editor.chosen;
  const [low, high] = editor.plot.range;
  const step = (high - low) * KEY_STEP;
  const done = () => { editor.changed(); editor.handlers.rest(); };
  const nudge = (/** @type {number} */ dx, /** @type {number} */ dy) => {
    moveAll(points, editor.indices, dx * step);
    const isLog = isChecked("log-opacity");
    for (const n of list === "opacities" ? editor.indices : []) {
      opacities[n][1] = fromHeight(clamp(toHeight(opacities[n][1], isLog) + dy * KEY_STEP * 2, 0, 1), isLog);
    }
    done();
  };
  const next = (/** @type {number} */ by) => clamp(index + by, 0, points.length - 1);
  const more = (/** @type {number} */ by) => editor.choose(list, next(by), new Set([...editor.indices, next(by)]));
  const insert = () => {
    const after = points[Math.min(index + 1, points.length - 1)][0];
    const value = after > points[index][0] ? (points[index][0] + after) / 2 : points[index][0] + step;
    editor.choose(list, list === "colors" ? add(colors, value, at(colors, value)) : add(opacities, value, at(opacities, value)));
    done();
  };
  /** @type {Record<string, () => void>} */
  const actions = {
    "Alt+ArrowLeft": () => nudge(-1, 0), "Alt+ArrowRight": () => nudge(1, 0), "Alt+ArrowUp": () => nudge(0, 1), "Alt+ArrowDown": () => nudge(0, -1),
    "Shift+ArrowLeft": () => more(-1), "Shift+ArrowRight": () => more(1),
    ArrowLeft: () => editor.choose(list, next(-1)), ArrowRight: () => editor.choose(list, next(1)),
    Delete: () => editor.delete(), Backspace: () => editor.delete(), Insert: insert,
    Enter: () => { if (list === "opacities") editor.showAround(points[index][0], isChecked("tent-alone")); },
  };
  const action = actions[`${event.altKey ? "Alt+" : ""}${event.shiftKey ? "Shift+" : ""}${event.key}`];
  if (!action) return;
  event.preventDefault();
  event.stopPropagation();
  action();
}
