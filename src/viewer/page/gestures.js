// Mouse, pen and fingers on the picture.

/** @typedef {{ turn: (x: number, y: number) => void, pan: (x: number, y: number) => void, roll: (degrees: number) => void,
 *   zoom: (factor: number, x: number, y: number) => void, rest: () => void }} Actions
 *   turn and pan by half heights of the picture; zoom about a place in half heights from the middle */

/** Radians that a drag over half the picture's height turns by. */
const TURN = Math.PI / 2;
/** Magnification of a wheel's notch, which most browsers count as 100 or 120. */
const WHEEL = 0.0015;
/** Milliseconds after the last turn of the wheel at which the hand rests. */
const WHEEL_REST = 180;

/** @param {import("./picture.js").Picture} picture @param {Actions} actions */
export function listen(picture, actions) {
  const { canvas } = picture;
  /** @type {Map<number, { x: number, y: number }>} */
  const pointers = new Map();
  let rest = 0;

  canvas.addEventListener("pointerdown", (event) => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, picture.place(event));
    event.preventDefault();
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = picture.place(event);
    if (pointers.size === 1) drag(event, now.x - before.x, now.y - before.y, now);
    else if (pointers.size === 2) pinch(event.pointerId, before, now);
    pointers.set(event.pointerId, now);
  });
  const up = (/** @type {PointerEvent} */ event) => {
    if (pointers.delete(event.pointerId) && pointers.size === 0) actions.rest();
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const { x, y } = picture.place(event);
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1;
    // A pinch on a touch pad comes as a wheel with Ctrl, in smaller steps.
    const speed = event.ctrlKey ? 6 * WHEEL : WHEEL;
    actions.zoom(Math.exp(-event.deltaY * lines * speed), x, y);
    clearTimeout(rest);
    rest = window.setTimeout(actions.rest, WHEEL_REST);
  }, { passive: false });

  /** @param {PointerEvent} event @param {number} dx @param {number} dy @param {{ x: number, y: number }} now */
  function drag(event, dx, dy, now) {
    if (event.altKey) {
      // About the middle of the picture.
      const [from, to] = [Math.atan2(now.y - dy, now.x - dx), Math.atan2(now.y, now.x)];
      actions.roll(((to - from) * 180) / Math.PI);
    } else if (event.shiftKey || event.buttons & 2) {
      actions.pan(dx, dy);
    } else if (event.buttons & 4) {
      actions.zoom(Math.exp(2 * dy), 0, 0);
    } else {
      actions.turn(dx * TURN, dy * TURN);
    }
  }

  /** Two fingers pan, zoom and roll at once. @param {number} id @param {{ x: number, y: number }} before @param {{ x: number, y: number }} now */
  function pinch(id, before, now) {
    const other = [...pointers].find(([key]) => key !== id)?.[1];
    if (!other) return;
    const [a, b] = [{ x: before.x - other.x, y: before.y - other.y }, { x: now.x - other.x, y: now.y - other.y }];
    const [from, to] = [Math.hypot(a.x, a.y), Math.hypot(b.x, b.y)];
    if (from < 1e-3 || to < 1e-3) return;
    actions.pan((now.x - before.x) / 2, (now.y - before.y) / 2);
    actions.zoom(to / from, (now.x + other.x) / 2, (now.y + other.y) / 2);
    let angle = Math.atan2(b.y, b.x) - Math.atan2(a.y, a.x);
    if (angle > Math.PI) angle -= 2 * Math.PI;
    if (angle < -Math.PI) angle += 2 * Math.PI;
    actions.roll((angle * 180) / Math.PI);
  }
}
