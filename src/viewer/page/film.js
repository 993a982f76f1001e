// Films: key cameras that are recorded by clicks, and the film along them.

import { download } from "./saving.js";
import { copy } from "./state.js";

/** @typedef {import("./state.js").Camera} Camera */
/** @typedef {{ camera: Camera, frame: number }} Shown */
/** @typedef {Shown & { time: number }} Key */

/** Seconds between a key camera and the next one, until another time is typed. */
const STEP = 2;
const KINDS = { gif: "image/gif", apng: "image/apng", mp4: "video/mp4" };

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));
const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (element(id));

/** A button with a name that says what it is for. @param {string} text @param {string} name @param {() => void} action */
function button(text, name, action) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.ariaLabel = made.title = name;
  made.addEventListener("click", action);
  return made;
}

export class Film {
  /** @param {{ shown: () => Shown, show: (shown: Shown) => void, steps: () => number, send: (request: object) => void,
   *   size: () => { width: number, height: number } }} page */
  constructor(page) {
    this.page = page;
    /** @type {Key[]} */
    this.keys = [];
    this.id = 0;
    /** The film that is being made. @type {{ id: number, name: string, kind: string, parts: Blob[] } | null} */
    this.making = null;
    /** Files of the last film's command. @type {{ name: string, text: string }[]} */
    this.files = [];
    element("film-add").addEventListener("click", () => this.record());
    element("film-make").addEventListener("click", () => this.make());
    element("film-cancel").addEventListener("click", () => this.cancel());
    element("film-files").addEventListener("click", () => {
      this.files.forEach(({ name, text }) => download(new Blob([text], { type: "application/json" }), name));
    });
    this.show();
  }

  /** Adds the camera and the step that are shown. */
  record() {
    const last = this.keys.at(-1);
    this.keys.push({ time: last ? last.time + STEP : 0, ...copy(this.page.shown()) });
    this.show();
  }

  /** Moves a key camera among the others; times stay in order. @param {number} from @param {number} to */
  move(from, to) {
    const times = this.keys.map(({ time }) => time);
    const [key] = this.keys.splice(from, 1);
    this.keys.splice(to, 0, key);
    this.keys.forEach((each, n) => { each.time = times[n]; });
    this.show(to);
  }

  /** @param {number} n */
  remove(n) {
    this.keys.splice(n, 1);
    this.show();
  }

  /** A time moves its key camera to where it belongs. @param {number} n @param {number} time */
  retime(n, time) {
    if (!Number.isFinite(time)) return this.show();
    const key = this.keys[n];
    key.time = time;
    this.keys.sort((a, b) => a.time - b.time);
    this.show(this.keys.indexOf(key));
  }

  /** @param {number} [focused] number of the key camera whose time keeps the focus */
  show(focused) {
    const list = element("film-keys");
    list.replaceChildren(...this.keys.map((key, n) => {
      const [item, time] = [document.createElement("li"), document.createElement("input")];
      Object.assign(time, { type: "number", step: "any", value: String(key.time), ariaLabel: `Seconds of key camera ${n + 1}` });
      time.addEventListener("change", () => this.retime(n, time.valueAsNumber));
      const up = button("↑", `Key camera ${n + 1} earlier`, () => this.move(n, n - 1));
      const down = button("↓", `Key camera ${n + 1} later`, () => this.move(n, n + 1));
      up.disabled = n === 0;
      down.disabled = n === this.keys.length - 1;
      item.append(
        time,
        this.showButton(key, n),
        up, down,
        button("×", `Delete key camera ${n + 1}`, () => this.remove(n)),
      );
      return item;
    }));
    if (focused !== undefined) list.children[focused]?.querySelector("input")?.focus();
    this.showState();
  }

  /** Tells the step of a sequence, too. @param {Key} key @param {number} n */
  showButton({ camera, frame }, n) {
    const [text, name] = this.page.steps() > 1 ? [`Show ${frame + 1}`, `, step ${frame + 1}`] : ["Show", ""];
    return button(text, `Show key camera ${n + 1}${name}`, () => this.page.show(copy({ camera, frame })));
  }

  /** @param {string} [text] */
  showState(text = "") {
    const isMaking = this.making !== null;
    element("film-make").toggleAttribute("disabled", isMaking || this.keys.length < 2);
    element("film-cancel").hidden = !isMaking;
    element("film-progress").hidden = !isMaking;
    element("film-files").hidden = this.files.length === 0;
    element("film-state").textContent = text || (this.keys.length < 2 ? "A film needs two key cameras or more." : "");
  }

  make() {
    const kind = /** @type {keyof typeof KINDS} */ (field("film-format").value);
    this.id += 1;
    this.making = { id: this.id, name: `layersplat.${kind}`, kind: KINDS[kind], parts: [] };
    const [rate, samples] = [field("film-rate").valueAsNumber || 25, field("film-samples").valueAsNumber || 1];
    const size = this.page.size();
    const width = field("film-width").valueAsNumber || size.width;
    const height = field("film-height").valueAsNumber || size.height;
    this.page.send({ type: "film", id: this.id, keys: copy(this.keys), width, height, samples, rate, format: kind });
    field("film-progress").value = "0";
    this.showState("The film waits.");
  }

  cancel() {
    if (this.making) this.page.send({ type: "cancel_film", id: this.making.id });
  }

  /** The request was refused, or the connection is lost. */
  giveUp() {
    if (!this.making) return;
    this.making = null;
    this.showState();
  }

  /** Another volume has other cameras. */
  clear() {
    this.giveUp();
    [this.keys, this.files] = [[], []];
    field("film-command").hidden = true;
    this.show();
  }

  /** How far the film is. @param {{ id: number, state: string, done: number, of: number }} message */
  progress({ id, state, done, of }) {
    const { making } = this;
    if (making?.id !== id) return;
    if (state === "drawing") {
      field("film-progress").value = String(done / of);
      this.showState(`Picture ${done + 1} of ${of}`);
      return;
    }
    this.making = null;
    if (state === "complete") download(new Blob(making.parts, { type: making.kind }), making.name);
    this.showState({ complete: `The film of ${of} pictures is saved as a download.`, cancelled: "The film was given up." }[state]);
  }

  /** A part of the film's file. @param {import("./connection.js").Received} part */
  part({ id, blob }) {
    if (this.making?.id === id) this.making.parts.push(blob);
  }

  /** @param {any} command */
  command({ id, line, keys_name: keysName, keys_text: keysText, transfer_name: name, transfer_text: text, more }) {
    if (this.making?.id !== id) return;
    this.files = [{ name: keysName, text: keysText }, { name, text }, ...more];
    field("film-command").value = line ?? "";
    field("film-command").hidden = line === null;
    this.showState("The film begins.");
  }
}
