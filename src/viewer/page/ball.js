// The ball on which lights are dragged.

/** Radius of a light's dot in the canvas, and distance within which it is chosen, as parts of the ball's radius. */
const DOT = 0.085;
const CATCH = 0.22;

/** @typedef {{ choose: (index: number) => void, aim: (x: number, y: number, isDone: boolean) => void, nudge: (x: number, y: number) => void,
 *   isOn: () => boolean }} Handlers places are −1 … 1 on the ball */

export class Ball {
  /** @param {Handlers} handlers */
  constructor(handlers) {
    this.handlers = handlers;
    this.canvas = /** @type {HTMLCanvasElement} */ (document.getElementById("ball"));
    /** Where the lights are. @type {{ x: number, y: number }[]} */
    this.places = [];
    this.chosen = 0;
    this.listen();
  }

  listen() {
    const { canvas, handlers } = this;
    let isHeld = false;
    const place = (/** @type {PointerEvent} */ event) => {
      const { left, top, width, height } = canvas.getBoundingClientRect();
      return { x: ((event.clientX - left) / width) * 2 - 1, y: 1 - ((event.clientY - top) / height) * 2 };
    };
    const aim = (/** @type {PointerEvent} */ event, /** @type {boolean} */ isDone) => {
      const { x, y } = place(event);
      handlers.aim(x, y, isDone);
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (!handlers.isOn()) return;
      isHeld = true;
      canvas.setPointerCapture(event.pointerId);
      const { x, y } = place(event);
      const other = this.places.findIndex((at, n) => n !== this.chosen && Math.hypot(at.x - x, at.y - y) < CATCH);
      const own = this.places[this.chosen];
      if (other >= 0 && Math.hypot(own.x - x, own.y - y) >= CATCH) handlers.choose(other);
      else aim(event, false);
    });
    canvas.addEventListener("pointermove", (event) => { if (isHeld) aim(event, false); });
    canvas.addEventListener("pointerup", (event) => {
      if (isHeld) aim(event, true);
      isHeld = false;
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!step || !handlers.isOn()) return;
      event.preventDefault();
      event.stopPropagation();
      handlers.nudge(step[0], step[1]);
    });
  }

  /** A ball that is lit by the chosen light, with a dot for each. @param {number[][]} directions @param {number} chosen */
  draw(directions, chosen) {
    const { canvas } = this;
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const radius = canvas.width / 2;
    this.chosen = chosen;
    this.places = directions.map(([x, y, z]) => ({ x: (x / Math.hypot(x, y, z)) * 0.92, y: (y / Math.hypot(x, y, z)) * 0.92 }));
    const toPixels = (/** @type {number} */ n) => [radius + this.places[n].x * radius, radius - this.places[n].y * radius];
    const [lx, ly] = toPixels(chosen);
    context.clearRect(0, 0, canvas.width, canvas.height);
    const shade = context.createRadialGradient(lx, ly, 2, lx, ly, radius * 1.9);
    const isBehind = directions[chosen][2] < 0;
    shade.addColorStop(0, isBehind ? "#5a6068" : "#fffdf4");
    shade.addColorStop(0.35, isBehind ? "#454b53" : "#b9bec4");
    shade.addColorStop(1, "#23282e");
    context.fillStyle = shade;
    context.beginPath();
    context.arc(radius, radius, radius - 1, 0, 2 * Math.PI);
    context.fill();
    directions.forEach((_, n) => {
      const [x, y] = toPixels(n);
      context.beginPath();
      context.arc(x, y, radius * DOT, 0, 2 * Math.PI);
      context.fillStyle = !this.handlers.isOn() ? "#888" : n === chosen ? "#ffd452" : "#f4f6f8";
      context.fill();
      context.lineWidth = 2;
      context.strokeStyle = "#1b232c";
      context.stroke();
    });
  }
}

/** The direction of a place on the ball's near side; places beside it are on its edge. @param {number} x @param {number} y */
export function onBall(x, y) {
  const r = Math.hypot(x, y);
  if (r >= 1) return [x / r, y / r, 0];
  return [x, y, Math.sqrt(1 - r * r)];
}
