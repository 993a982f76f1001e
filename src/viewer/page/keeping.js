// Saved pictures, and the command that makes them.

import { download, toClipboard } from "./saving.js";

/** @typedef {import("./session.js").Session} Session */

const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

export class Keeping {
  /** @param {Session} session @param {import("./status.js").Status} status */
  constructor(session, status) {
    this.session = session;
    this.status = status;
    /** Whether the next command is for the clipboard. */
    this.wantsCommand = false;
    field("save").addEventListener("click", () => this.save());
    field("copy").addEventListener("click", () => this.copy());
  }

  /** Offers the size of the picture on the page. */
  offerSize() {
    const { width, height } = this.session.picture.size();
    [field("save-width").value, field("save-height").value] = [String(width), String(height)];
  }

  get request() {
    const [width, height, samples] = ["save-width", "save-height", "save-samples"].map((name) => field(name).valueAsNumber || 1);
    return { camera: this.session.state.camera, width, height, samples };
  }

  save() {
    this.session.connection.send({ type: "save", ...this.request });
  }

  copy() {
    this.wantsCommand = true;
    this.session.connection.send({ type: "command", ...this.request });
  }

  /** @param {any} answer */
  async show({ line, transfer_name: name, transfer_text: text }) {
    const box = field("command");
    box.value = line;
    box.hidden = false;
    if (!this.wantsCommand) return;
    this.wantsCommand = false;
    download(new Blob([text], { type: "application/json" }), name);
    const isCopied = await toClipboard(line);
    const file = `It needs ${name}, which is saved as a download.`;
    this.status.problem(isCopied ? `The command is copied. ${file}` : `Copy the command from the panel. ${file}`, "note");
  }
}
