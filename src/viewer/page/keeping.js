// Saved pictures, and the command or the program in Python that makes them.

import { downloadBeside, toClipboard } from "./saving.js";

/** @typedef {import("./session.js").Session} Session */

const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

export class Keeping {
  /** @param {Session} session @param {import("./status.js").Status} status */
  constructor(session, status) {
    this.session = session;
    this.status = status;
    /** What the next answer is for. */
    this.wants = /** @type {"line" | "python" | null} */ (null);
    field("save").addEventListener("click", () => this.save());
    field("copy").addEventListener("click", () => this.copy("line"));
    field("copy-python").addEventListener("click", () => this.copy("python"));
  }

  /** Another volume has other commands. */
  clear() {
    this.wants = null;
    field("command").hidden = true;
  }

  /** Offers the size of the picture on the page. */
  offerSize() {
    const { width, height } = this.session.picture.size();
    [field("save-width").value, field("save-height").value] = [String(width), String(height)];
  }

  get request() {
    const [width, height, samples] = ["save-width", "save-height", "save-samples"].map((name) => field(name).valueAsNumber || 1);
    return { camera: this.session.state.camera, width, height, samples, format: field("save-format").value };
  }

  save() {
    this.session.connection.send({ type: "save", ...this.request });
  }

  /** @param {"line" | "python"} what */
  copy(what) {
    this.wants = what;
    this.session.connection.send({ type: "command", ...this.request });
  }

  /** @param {any} answer */
  async show(answer) {
    const { line, python } = answer;
    const { wants } = this;
    const box = field("command");
    box.value = wants === "python" ? python : line;
    box.hidden = false;
    if (!wants) return;
    this.wants = null;
    const needs = downloadBeside(answer);
    const isCopied = await toClipboard(box.value);
    const what = wants === "python" ? "program" : "command";
    this.status.problem(isCopied ? `The ${what} is copied. ${needs}` : `Copy the ${what} from the panel. ${needs}`, "note");
  }
}
