// Mouse, pen and fingers on the picture.

/** @typedef {{ x: number, y: number }} Place in half heights from the middle of the picture */
/** @typedef {{ move: (place: Place) => void, end: () => void }} Grab */
/** @typedef {{ turn: (x: number, y: number) => void, pan: (x: number, y: number) => void, roll: (degrees: number) => void,
 *   zoom: (factor: number, x: number, y: number) => void, rest: () => void, hasMomentum: () => boolean,
 *   grab: (place: Place) => Grab | null, click: (place: Place) => void, pivot: (place: Place) => void }} Actions
 *   turn and pan by half heights of the picture; zoom about a place; `grab`: of a handle in the picture */

/** Radians that a drag over half the picture's height turns by. */
const TURN = Math.PI / 2;
/** Magnification of a wheel's notch, which most browsers count as 100 or 120. */
const WHEEL = 0.0015;
/** Pixels that a click may move by. */
const STILL = 4;
/** Part of the momentum that is left after a frame, and what is too slow to be seen, in radians per frame. */
const LEFT = 0.94;
const SLOWEST = 0.0005;
/** Milliseconds after the last turn of the wheel at which the hand rests. */
const WHEEL_REST = 180;

/** @param {import("./picture.js").Picture} picture @param {Actions} actions */
export function listen(picture, actions) {
  const { canvas } = picture;
  /** @type {Map<number, { x: number, y: number }>} */
  const pointers = new Map();
  let rest = 0;
  /** @type {Grab | null} */
  let held = null;
  /** Where the only pointer went down, while it may become a click. @type {MouseEvent | null} */
  let pressed = null;
  /** Radians of the last movement, and when it was. */
  let speed = { x: 0, y: 0, at: 0 };
  let gliding = 0;
  /** Whether the view changed since the hand rested. */
  let isMoved = false;

  canvas.addEventListener("pointerdown", (event) => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    cancelAnimationFrame(gliding);
    pressed = pointers.size === 0 && event.button === 0 ? event : null;
    held = pointers.size === 0 && event.button === 0 ? actions.grab(picture.place(event)) : null;
    speed = { x: 0, y: 0, at: 0 };
    pointers.set(event.pointerId, picture.place(event));
    event.preventDefault();
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = picture.place(event);
    if (pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) >= STILL) pressed = null;
    isMoved ||= !held;
    if (held) held.move(now);
    else if (pointers.size === 1) drag(event, now.x - before.x, now.y - before.y, now);
    else if (pointers.size === 2) pinch(event.pointerId, before, now);
    pointers.set(event.pointerId, now);
  });
  const up = (/** @type {PointerEvent} */ event) => {
    if (!pointers.delete(event.pointerId) || pointers.size > 0) return;
    if (held) held.end();
    else if (pressed && event.type === "pointerup") actions.click(picture.place(event));
    else if (actions.hasMomentum() && performance.now() - speed.at < 60) return glide();
    [held, pressed] = [null, null];
    rested();
  };
  const rested = () => {
    if (isMoved) actions.rest();
    isMoved = false;
  };
  canvas.addEventListener("dblclick", (event) => actions.pivot(picture.place(event)));
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
      speed = { x: dx * TURN, y: dy * TURN, at: performance.now() };
    }
  }

  /** Turns on as the hand did, slower and slower. */
  function glide() {
    if (Math.hypot(speed.x, speed.y) < SLOWEST) return rested();
    actions.turn(speed.x, speed.y);
    speed = { x: speed.x * LEFT, y: speed.y * LEFT, at: 0 };
    gliding = requestAnimationFrame(glide);
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
