// Lights, shadows and ambient occlusion. The page moves the first light; others, given on the command line, stay.

/** @typedef {import("./state.js").Look} Look */
/** @typedef {import("./state.js").Light} Light */

/** Direction of the light with which shadows are seen, from the camera: left, above, in front. */
const BESIDE = [-1, 1, 1];
/** Part of the ball that a key moves the light by. */
const KEY_STEP = 0.08;

/** @param {string} id */
const element = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

export class Lighting {
  /** @param {{ change: (change: (look: Look) => void, isDone: boolean) => void,
   *   toCamera: (world: number[]) => number[], toWorld: (camera: number[]) => number[] }} page */
  constructor(page) {
    this.page = page;
    this.ball = /** @type {HTMLCanvasElement} */ (document.getElementById("ball"));
    /** @type {Look | null} */
    this.look = null;
    this.listen();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  /** @param {Look} look */
  set(look) {
    this.look = look;
    const light = look.lights[0] ?? null;
    const isBeside = light === null && look.shadows;
    element("shading").checked = look.shading;
    element("headlight").checked = !isBeside && (light === null || light.direction === null);
    element("lights-follow").checked = look.lights_follow || isBeside;
    element("strength").value = String(light?.strength ?? 1);
    element("shadows").checked = look.shadows;
    element("shadow-strength").value = String(look.shadow_strength);
    element("ambient-occlusion").checked = look.ambient_occlusion;
    const isLit = look.shading && (look.blend === "composite" || look.blend === "iso");
    for (const id of ["headlight", "lights-follow", "strength", "shadows", "ambient-occlusion"]) element(id).disabled = !isLit;
    element("lights-follow").disabled ||= element("headlight").checked;
    element("shadow-strength").disabled = !isLit || !look.shadows;
    this.draw();
  }

  /** Direction of the light in the camera's axes: right, up, to the viewer. */
  direction() {
    const look = /** @type {Look} */ (this.look);
    const given = look.lights[0]?.direction;
    if (!given) return look.shadows && look.lights.length === 0 ? BESIDE : [0, 0, 1];
    return look.lights_follow ? given : this.page.toCamera(given);
  }

  /** Sets the first light. @param {(light: Light) => void} change @param {boolean} isDone */
  changeLight(change, isDone) {
    this.page.change((look) => {
      const first = look.lights[0] ?? { direction: null, strength: 1, angle: 0 };
      change(first);
      look.lights = [first, ...look.lights.slice(1)];
    }, isDone);
  }

  /** @param {number[]} camera the direction, in the camera's axes @param {boolean} isDone */
  point(camera, isDone) {
    const follows = element("lights-follow").checked;
    this.page.change((look) => {
      const first = look.lights[0] ?? { direction: null, strength: 1, angle: 0 };
      const direction = (follows ? camera : this.page.toWorld(camera)).map((x) => Number(x.toFixed(4)));
      look.lights = [{ ...first, direction }, ...look.lights.slice(1)];
      look.lights_follow = follows;
    }, isDone);
  }

  listen() {
    const { page } = this;
    const check = (/** @type {string} */ id, /** @type {(look: Look, on: boolean) => void} */ change) => {
      element(id).addEventListener("change", () => page.change((look) => change(look, element(id).checked), true));
    };
    check("shading", (look, on) => { look.shading = on; });
    check("ambient-occlusion", (look, on) => { look.ambient_occlusion = on; });
    check("shadows", (look, on) => {
      look.shadows = on;
      // A light at the camera casts no visible shadow.
      if (on && (look.lights[0]?.direction ?? null) === null) {
        look.lights = [{ direction: [...BESIDE], strength: look.lights[0]?.strength ?? 1, angle: 0 }, ...look.lights.slice(1)];
        look.lights_follow = true;
      }
    });
    check("headlight", (look, on) => {
      const first = look.lights[0] ?? { direction: null, strength: 1, angle: 0 };
      look.lights = [{ ...first, direction: on ? null : [...BESIDE] }, ...look.lights.slice(1)];
      look.lights_follow = true;
    });
    check("lights-follow", (look, on) => {
      const camera = this.direction();
      if (look.lights[0]?.direction) look.lights[0].direction = on ? camera : page.toWorld(camera);
      look.lights_follow = on;
    });
    const slide = (/** @type {string} */ id, /** @type {(value: number, isDone: boolean) => void} */ change) => {
      element(id).addEventListener("input", () => change(element(id).valueAsNumber, false));
      element(id).addEventListener("change", () => change(element(id).valueAsNumber, true));
    };
    slide("strength", (value, isDone) => this.changeLight((light) => { light.strength = value; }, isDone));
    slide("shadow-strength", (value, isDone) => page.change((look) => { look.shadow_strength = value; }, isDone));
    this.listenToBall();
  }

  listenToBall() {
    const { ball } = this;
    let isHeld = false;
    const aim = (/** @type {PointerEvent} */ event, /** @type {boolean} */ isDone) => {
      const { left, top, width, height } = ball.getBoundingClientRect();
      const [x, y] = [((event.clientX - left) / width) * 2 - 1, 1 - ((event.clientY - top) / height) * 2];
      this.point(onBall(x, y), isDone);
    };
    ball.addEventListener("pointerdown", (event) => {
      if (element("strength").disabled) return;
      isHeld = true;
      ball.setPointerCapture(event.pointerId);
      aim(event, false);
    });
    ball.addEventListener("pointermove", (event) => { if (isHeld) aim(event, false); });
    ball.addEventListener("pointerup", (event) => {
      if (isHeld) aim(event, true);
      isHeld = false;
    });
    ball.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!step || element("strength").disabled) return;
      event.preventDefault();
      event.stopPropagation();
      const [x, y, z] = this.direction();
      const length = Math.hypot(x, y, z);
      this.point(onBall(x / length + step[0] * KEY_STEP, y / length + step[1] * KEY_STEP), true);
    });
  }

  /** A lit ball. */
  draw() {
    if (!this.look) return;
    const { ball } = this;
    const context = /** @type {CanvasRenderingContext2D} */ (ball.getContext("2d"));
    const [x, y, z] = this.direction();
    const length = Math.hypot(x, y, z);
    const radius = ball.width / 2;
    const [lx, ly] = [radius + (x / length) * radius * 0.92, radius - (y / length) * radius * 0.92];
    context.clearRect(0, 0, ball.width, ball.height);
    const shade = context.createRadialGradient(lx, ly, 2, lx, ly, radius * 1.9);
    const isBehind = z < 0;
    shade.addColorStop(0, isBehind ? "#5a6068" : "#fffdf4");
    shade.addColorStop(0.35, isBehind ? "#454b53" : "#b9bec4");
    shade.addColorStop(1, "#23282e");
    context.fillStyle = shade;
    context.beginPath();
    context.arc(radius, radius, radius - 1, 0, 2 * Math.PI);
    context.fill();
    context.beginPath();
    context.arc(lx, ly, 6, 0, 2 * Math.PI);
    context.fillStyle = element("strength").disabled ? "#888" : "#ffd452";
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = "#1b232c";
    context.stroke();
  }
}

/** The direction of a place on the ball's near side; places beside it are on its edge. @param {number} x @param {number} y */
function onBall(x, y) {
  const r = Math.hypot(x, y);
  if (r >= 1) return [x / r, y / r, 0];
  return [x, y, Math.sqrt(1 - r * r)];
}
