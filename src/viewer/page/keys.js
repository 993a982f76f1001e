// Keys of the whole page, and the list of them.

/** @typedef {{ keys: string, does: string }} Line */

/** For the list that `?` opens. @type {Line[]} */
export const LINES = [
  { keys: "drag, arrow keys", does: "turn" },
  { keys: "Shift + drag or arrow keys, right drag", does: "pan" },
  { keys: "wheel, pinch, + −", does: "zoom" },
  { keys: "Alt + drag, comma, full stop", does: "roll" },
  { keys: "1 … 6", does: "front, right, back, left, above, below" },
  { keys: "7 8", does: "two corners" },
  { keys: "f", does: "fit what is visible" },
  { keys: "r", does: "view, look, curves and slices as at the start" },
  { keys: "o", does: "parallel or perspective" },
  { keys: "m", does: "measure a distance: click on both ends" },
  { keys: "t", does: "show around a value: click on the picture, drag on the curve" },
  { keys: "Enter on the picture", does: "value at its middle, or use the tool there" },
  { keys: "Escape", does: "put the tool away" },
  { keys: "double click, d", does: "turn about what is seen there, or at the middle" },
  { keys: "l b x", does: "legend and scale bar, box, axes" },
  { keys: "p", does: "fold the panel" },
  { keys: "v", does: "slices beside the picture" },
  { keys: "Space", does: "play a sequence, or pause" },
  { keys: "[ ]", does: "step before, step after" },
  { keys: "k", does: "record the view for a film" },
  { keys: "s", does: "save the picture" },
  { keys: "c, y", does: "copy the command, or the Python program, that makes the picture" },
  { keys: "Ctrl + Z, Ctrl + Y", does: "undo, redo" },
  { keys: "?", does: "this list" },
  { keys: "on a slice: drag, arrow keys", does: "move the crosshair" },
  { keys: "on a slice: wheel, Page Up, Page Down", does: "next slice" },
  { keys: "on a slice: right drag", does: "width and level of the window" },
  { keys: "on the curve: ← →, with Shift", does: "choose a point, choose several" },
  { keys: "on the curve: Shift + click or drag", does: "choose several points" },
  { keys: "on the curve: Alt + arrow keys", does: "move the chosen points" },
  { keys: "on the curve: Insert, Delete", does: "add a point, delete the chosen ones" },
  { keys: "on the curve: Enter", does: "show around the value of the point" },
];

/** @param {HTMLElement} list */
export function fill(list) {
  for (const { keys, does } of LINES) {
    const [term, text] = [document.createElement("dt"), document.createElement("dd")];
    [term.textContent, text.textContent] = [keys, does];
    list.append(term, text);
  }
}

/** Whether keys belong to the element that has the focus. @param {KeyboardEvent} event */
function isTyping({ target, key }) {
  if (!(target instanceof HTMLElement)) return false;
  // A slice has the keys that move; letters are the page's.
  if (target.matches("#slices canvas")) return key.length > 1;
  if (key === " " && target.matches("button, summary, input")) return true;
  return target.matches("input:not([type=checkbox]), select, textarea, #curve, #colors, #ball, dialog *");
}

/** @param {Record<string, (event: KeyboardEvent) => void>} actions by key, `Shift+` and `Ctrl+` before it */
export function listen(actions) {
  addEventListener("keydown", (event) => {
    const control = event.ctrlKey || event.metaKey;
    if (event.altKey || (isTyping(event) && !control)) return;
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const shift = event.shiftKey && (event.key.length > 1 || control) ? "Shift+" : "";
    const action = actions[`${control ? "Ctrl+" : ""}${shift}${name}`];
    // Arrow keys of a focused button or summary still scroll nothing: the picture has them.
    if (!action || (isTyping(event) && /[zy]$/.test(name) && event.target instanceof HTMLTextAreaElement)) return;
    event.preventDefault();
    action(event);
  });
}
