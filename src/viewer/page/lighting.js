// Lights on a ball, shadows and ambient occlusion, and the studio.

import { Ball, onBall } from "./ball.js";
import { fromHex, toHex } from "./editing.js";

/** @typedef {import("./state.js").Look} Look */
/** @typedef {import("./state.js").Light} Light */

/** Direction of the light with which shadows are seen, from the camera: left, above, in front. */
const BESIDE = [-1, 1, 1];
/** Direction of a light that is added: right, a little below. */
const ADDED = [1, -0.3, 1];
/** Most lights. */
const MOST = 4;
/** Part of the ball that a key moves the light by. */
const KEY_STEP = 0.08;

const WHITE = [1, 1, 1];

const rounded = (/** @type {number} */ x) => Number(x.toFixed(4));

/** @param {string} id */
const element = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

export class Lighting {
  /** @param {{ change: (change: (look: Look) => void, isDone: boolean) => void,
   *   toCamera: (world: number[]) => number[], toWorld: (camera: number[]) => number[] }} page */
  constructor(page) {
    this.page = page;
    /** @type {Look | null} */
    this.look = null;
    /** The light that is changed. */
    this.chosen = 0;
    /** What the fields do not have, and why. @type {Record<string, string>} */
    this.unavailable = {};
    /** The studio as it begins, its lights along the camera's axes. @type {{ look: import("./state.js").Studio, lights: Light[] }} */
    this.studio = { look: { sky_up: [0, 1, 0], scattering: 0.95, exposure: 0 }, lights: [] };
    /** The light of the other look, to which the page returns. @type {Pick<Look, "studio" | "lights" | "lights_follow"> | null} */
    this.other = null;
    this.ball = new Ball({
      choose: (index) => { this.chosen = index; this.show(); },
      aim: (x, y, isDone) => this.point(onBall(x, y), isDone),
      nudge: (x, y) => {
        const [dx, dy, dz] = this.directions[this.chosen];
        const length = Math.hypot(dx, dy, dz);
        this.point(onBall(dx / length + x * KEY_STEP, dy / length + y * KEY_STEP), true);
      },
      isOn: () => !element("strength").disabled,
    });
    this.listen();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  /** @param {{ unavailable: Record<string, string>, studio: { look: import("./state.js").Studio, lights: Light[] } }} hello */
  begin({ unavailable, studio }) {
    [this.unavailable, this.studio, this.other] = [unavailable, studio, null];
  }

  /** @param {Look} look */
  set(look) {
    this.look = look;
    this.show();
  }

  show() {
    const look = /** @type {Look} */ (this.look);
    this.chosen = Math.min(this.chosen, Math.max(look.lights.length - 1, 0));
    const light = look.lights[this.chosen] ?? null;
    const isBeside = light === null && look.shadows;
    const isShaded = look.blend === "composite" || look.blend === "iso";
    const isStudio = look.studio !== null && isShaded;
    element("lit").value = look.studio ? "studio" : "plain";
    element("lit").disabled = !isShaded;
    for (const id of /** @type {const} */ (["exposure", "scattering"])) {
      element(id).value = String((look.studio ?? this.studio.look)[id]);
      element(id).disabled = !isStudio;
    }
    element("shading").disabled = isStudio;
    element("shading").checked = look.shading;
    element("headlight").checked = !isBeside && (light === null || light.direction === null);
    element("lights-follow").checked = look.lights_follow || isBeside;
    element("strength").value = String(light?.strength ?? 1);
    element("angle").value = String(light?.angle ?? 0);
    element("light-color").value = toHex(light?.color ?? WHITE);
    element("shadows").checked = look.shadows;
    element("shadow-strength").value = String(look.shadow_strength);
    element("ambient-occlusion").checked = look.ambient_occlusion;
    const isLit = isStudio || (look.shading && isShaded);
    const ids = ["headlight", "lights-follow", "strength", "light-color", "light", "add-light", "delete-light"];
    for (const id of ids) element(id).disabled = !isLit;
    for (const id of ["shadows", "ambient-occlusion"]) element(id).disabled = !isLit || isStudio || id in this.unavailable;
    element("lights-follow").disabled ||= look.lights.every(({ direction }) => direction === null) && !isBeside && !isStudio;
    element("shadow-strength").disabled = element("shadows").disabled || !look.shadows;
    element("angle").disabled = !isLit || !(look.shadows || isStudio) || element("headlight").checked;
    element("add-light").disabled ||= look.lights.length >= MOST;
    element("delete-light").disabled ||= look.lights.length < 2;
    const count = Math.max(look.lights.length, 1);
    const list = element("light");
    if (list.childElementCount !== count) {
      list.replaceChildren(...Array.from({ length: count }, (_, n) => new Option(`light ${n + 1}`, String(n))));
    }
    list.value = String(this.chosen);
    this.draw();
  }

  /** Directions of all lights in the camera's axes: right, up, to the viewer. */
  get directions() {
    const look = /** @type {Look} */ (this.look);
    if (look.lights.length === 0) return [look.shadows ? BESIDE : [0, 0, 1]];
    return look.lights.map(({ direction }) => {
      if (!direction) return [0, 0, 1];
      return look.lights_follow ? direction : this.page.toCamera(direction);
    });
  }

  /** The lights of a look as a list. @param {Look} look */
  listed(look) {
    if (look.lights.length > 0) return look.lights;
    return [{ direction: look.shadows ? [...BESIDE] : null, strength: 1, angle: 0, color: WHITE }];
  }

  /** Chooses the studio, or the plain look. The light of either stays as it was left. @param {Look} look @param {boolean} isStudio */
  choose(look, isStudio) {
    if ((look.studio !== null) === isStudio) return;
    const { studio, lights, lights_follow } = look;
    const toWorld = (/** @type {number[]} */ direction) => this.page.toWorld(direction).map(rounded);
    const first = () => ({
      // Light stays in the world: turning computes none anew.
      studio: { ...this.studio.look, sky_up: toWorld(this.studio.look.sky_up) },
      lights: this.studio.lights.map((light) => ({ ...light, direction: light.direction && toWorld(light.direction) })),
      lights_follow: false,
    });
    // Undo may have led to the look that was left.
    const left = this.other && (this.other.studio !== null) === isStudio ? this.other : null;
    Object.assign(look, left ?? (isStudio ? first() : { studio: null, lights: [], lights_follow: true }));
    this.other = { studio, lights, lights_follow };
  }

  /** Changes the chosen light. @param {(light: Light, look: Look) => void} change @param {boolean} isDone */
  changeLight(change, isDone) {
    this.page.change((look) => {
      // Without lights, shadows have one that moves with the camera.
      if (look.lights.length === 0 && look.shadows) look.lights_follow = true;
      look.lights = this.listed(look);
      change(look.lights[this.chosen], look);
    }, isDone);
  }

  /** @param {number[]} camera the direction, in the camera's axes @param {boolean} isDone */
  point(camera, isDone) {
    this.changeLight((light, look) => {
      const hasOthers = look.lights.some((other) => other !== light && other.direction !== null);
      // One switch is for all lights: the first direction decides as the box says.
      if (!hasOthers && light.direction === null && !look.studio) look.lights_follow = true;
      light.direction = (look.lights_follow ? camera : this.page.toWorld(camera)).map(rounded);
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
      if (on && look.lights.every(({ direction }) => direction === null)) {
        const { strength, color } = this.listed(look)[0];
        look.lights = [{ direction: [...BESIDE], strength, angle: 0, color }, ...look.lights.slice(1)];
        look.lights_follow = true;
      }
    });
    check("lights-follow", (look, on) => {
      const directions = this.directions;
      look.lights = this.listed(look);
      look.lights.forEach((light, n) => { if (light.direction) light.direction = on ? directions[n] : page.toWorld(directions[n]); });
      if (look.studio) look.studio.sky_up = on ? page.toCamera(look.studio.sky_up) : page.toWorld(look.studio.sky_up);
      look.lights_follow = on;
    });
    element("lit").addEventListener("change", () => page.change((look) => this.choose(look, element("lit").value === "studio"), true));
    element("headlight").addEventListener("change", () => {
      if (!element("headlight").checked) this.point([...BESIDE], true);
      else this.changeLight((light) => { light.direction = null; }, true);
    });
    element("light").addEventListener("change", () => { this.chosen = Number(element("light").value); this.show(); });
    element("add-light").addEventListener("click", () => {
      this.chosen = this.listed(/** @type {Look} */ (this.look)).length;
      page.change((look) => {
        if (look.lights.length === 0 && look.shadows) look.lights_follow = true;
        look.lights = [...this.listed(look), { direction: null, strength: 0.5, angle: 0, color: WHITE }];
        if (look.lights.every(({ direction }) => direction === null) && !look.studio) look.lights_follow = true;
        look.lights[this.chosen].direction = look.lights_follow ? [...ADDED] : page.toWorld(ADDED).map(rounded);
      }, true);
    });
    element("delete-light").addEventListener("click", () => page.change((look) => {
      if (look.lights.length > 1) look.lights.splice(this.chosen, 1);
    }, true));
    const slide = (/** @type {string} */ id, /** @type {(value: number, isDone: boolean) => void} */ change) => {
      element(id).addEventListener("input", () => change(element(id).valueAsNumber, false));
      element(id).addEventListener("change", () => change(element(id).valueAsNumber, true));
    };
    slide("strength", (value, isDone) => this.changeLight((light) => { light.strength = value; }, isDone));
    slide("angle", (value, isDone) => this.changeLight((light) => { light.angle = value; }, isDone));
    for (const [event, isDone] of /** @type {const} */ ([["input", false], ["change", true]])) {
      element("light-color").addEventListener(event, () => {
        this.changeLight((light) => { light.color = fromHex(element("light-color").value).map((part) => Number(part.toFixed(4))); }, isDone);
      });
    }
    for (const id of /** @type {const} */ (["exposure", "scattering"])) {
      slide(id, (value, isDone) => page.change((look) => { if (look.studio) look.studio[id] = value; }, isDone));
    }
    slide("shadow-strength", (value, isDone) => page.change((look) => { look.shadow_strength = value; }, isDone));
  }

  draw() {
    if (this.look) this.ball.draw(this.directions, this.chosen);
  }
}
