// Values and positions in the picture: what is under the cursor, distances, and tools that use a click.

import { projected, sum, times } from "./camera.js";

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {{ position: number[], voxel: number[], value: number | null, values: number[], labels: { id: number, name: string }[] }} Point */
/** @typedef {"turn" | "measure" | "tent"} Tool */

/** Milliseconds that the cursor rests before the value under it is asked for. */
const REST = 120;
/** Buttons of the tools. */
const BUTTONS = /** @type {const} */ ({ measure: "measure", tent: "tent" });

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
/** @param {number} number */
const short = (number) => String(Number(number.toPrecision(5)));

export class Reading {
  /** @param {Session} session @param {{ draw: () => void, tent: (value: number) => void, say: (sentence: string) => void }} page */
  constructor(session, page) {
    this.session = session;
    this.page = page;
    /** @type {Tool} */
    this.tool = "turn";
    /** Ends of the distance. @type {number[][]} */
    this.ends = [];
    /** World point that turns are about, if it was chosen. @type {number[] | null} */
    this.pivot = null;
    this.id = 0;
    /** What is done with answers, by number. @type {Map<number, (point: Point | null) => void>} */
    this.waiting = new Map();
    this.rest = 0;
    this.line = element("reading");
    const { canvas } = session.picture;
    canvas.addEventListener("pointermove", (event) => this.hover(event));
    canvas.addEventListener("pointerleave", () => this.hover(null));
    canvas.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      // By keyboard, the middle of the picture is the place.
      if (this.tool === "turn") this.read({ x: 0, y: 0 });
      else this.click({ x: 0, y: 0 });
    });
    for (const [tool, id] of Object.entries(BUTTONS)) element(id).addEventListener("click", () => this.toggle(/** @type {Tool} */ (tool)));
    element("unmeasure").addEventListener("click", () => this.clear());
  }

  /** Another volume: what was read of the last one is gone. */
  begin() {
    this.pivot = null;
    this.waiting.clear();
    this.line.textContent = "";
    this.clear();
  }

  /** @param {Tool} tool is taken, or put away if it is in the hand */
  toggle(tool) {
    this.tool = this.tool === tool ? "turn" : tool;
    for (const [name, id] of Object.entries(BUTTONS)) element(id).setAttribute("aria-pressed", String(name === this.tool));
    this.session.picture.canvas.classList.toggle("aims", this.tool !== "turn");
  }

  putAway() {
    if (this.tool !== "turn") this.toggle(this.tool);
  }

  clear() {
    this.ends = [];
    this.page.draw();
    this.showDistance();
  }

  /** Asks for the point that is seen at a place. @param {Place} place @param {(point: Point | null) => void} then */
  pick({ x, y }, then) {
    if (!this.session.history) return;
    // The server draws what is seen before it answers.
    this.session.sync();
    this.id += 1;
    this.waiting.set(this.id, then);
    const { height } = this.session.picture.size();
    this.session.connection.send({ type: "pick", id: this.id, camera: this.session.state.camera, height, x, y });
  }

  /** @param {{ id: number, point: Point | null }} answer */
  picked({ id, point }) {
    const then = this.waiting.get(id);
    // Answers come in order: those of a lost connection never do.
    for (const known of [...this.waiting.keys()]) if (known <= id) this.waiting.delete(known);
    then?.(point);
  }

  /** @param {PointerEvent | null} event */
  hover(event) {
    clearTimeout(this.rest);
    if (this.line.textContent) this.line.textContent = "";
    if (!event || event.buttons !== 0) return;
    const place = this.session.picture.place(event);
    this.rest = window.setTimeout(() => { if (!this.session.isMoving) this.read(place); }, REST);
  }

  /** Shows value and position at a place. @param {Place} place */
  read(place) {
    this.pick(place, (point) => { this.line.textContent = point ? this.described(point) : "nothing is seen here"; });
  }

  get unit() {
    return this.session.hello.volume.length_units ?? "";
  }

  /** @param {Point} point */
  described({ position, voxel, value, values, labels }) {
    const { channels } = this.session.hello;
    const components = ["red", "green", "blue", "alpha"];
    const named = values.map((one, n) => `${channels[n]?.name ?? components[n]} ${short(one)}`);
    const ids = labels.map(({ id, name }) => (name === `label ${id}` ? name : `${name} (label ${id})`));
    const own = value === null || named.length > 0 ? [] : [`value ${short(value)}`];
    const what = [...ids, ...named, ...own].join(", ");
    const list = (/** @type {number[]} */ numbers, /** @type {number} */ digits) => numbers.map((x) => x.toFixed(digits)).join(", ");
    return `${what} at ${list(position, 2)}${this.unit && ` ${this.unit}`} (voxel ${list(voxel, 1)})`;
  }

  /** A click with the tool in the hand. @param {Place} place */
  click(place) {
    if (this.tool === "turn") return;
    const { tool } = this;
    this.pick(place, (point) => {
      if (!point) return this.page.say("Nothing is seen at this place. Choose a place of the volume.");
      if (tool === "tent") return this.page.tent(point.values[this.session.field] ?? point.value ?? 0);
      this.ends = this.ends.length === 1 ? [...this.ends, point.position] : [point.position];
      this.showDistance();
      this.page.draw();
    });
  }

  /** Turns are about what is seen at a place from now on, or about the centre again. @param {Place} place */
  choosePivot(place) {
    this.pick(place, (point) => {
      this.pivot = point?.position ?? null;
      this.page.say(point ? "Turns are about this point now. Double-click beside the volume for the centre." : "Turns are about the centre of the view.");
      this.page.draw();
    });
  }

  get distance() {
    return this.ends.length === 2 ? Math.hypot(...sum(this.ends[1], times(this.ends[0], -1))) : null;
  }

  showDistance() {
    const { distance } = this;
    const text = ["", "choose the other end"][this.ends.length] ?? `${short(distance ?? 0)} ${this.unit || "units"}`;
    element("distance").textContent = text;
    element("unmeasure").toggleAttribute("disabled", this.ends.length === 0);
  }

  /** @param {import("./overlay.js").Overlay} overlay */
  paint(overlay) {
    const { hello, state } = this.session;
    const place = (/** @type {number[]} */ point) => projected(point, state.camera, hello.frame);
    if (this.pivot) {
      const at = place(this.pivot);
      const arm = 9 * overlay.pixel;
      overlay.line([{ x: at.x - arm, y: at.y }, { x: at.x + arm, y: at.y }], "#ff9e3d");
      overlay.line([{ x: at.x, y: at.y - arm }, { x: at.x, y: at.y + arm }], "#ff9e3d");
    }
    const ends = this.ends.map(place);
    if (ends.length === 2) overlay.line(ends, "#ffe14d");
    for (const end of ends) overlay.dot(end, "#ffe14d", 4);
    if (this.distance !== null) {
      const [a, b] = ends;
      overlay.label({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 + 10 * overlay.pixel }, `${short(this.distance)} ${this.unit || "units"}`);
    }
  }
}
