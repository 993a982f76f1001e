// Other volumes: those that the server offers, and files that are dropped onto the page.

import { Raw } from "./raw.js";

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));
const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (element(id));

/** Ends of the names of transfer functions; other files are volumes. */
const TRANSFERS = /\.(json|vp|csv)$/i;
/** What is done with a volume that is being opened. @type {Record<string, string>} */
const STAGES = { reading: "reading", looking: "looking at its values" };

/** The files of a folder, without those of its folders and hidden ones. @param {FileSystemDirectoryEntry} folder @returns {Promise<File[]>} */
async function inFolder(folder) {
  const reader = folder.createReader();
  /** @type {File[]} */
  const found = [];
  for (;;) {
    /** @type {FileSystemEntry[]} */
    const some = await new Promise((done, failed) => reader.readEntries(done, failed));
    if (some.length === 0) return found;
    const files = /** @type {FileSystemFileEntry[]} */ (some.filter(({ isFile, name }) => isFile && !name.startsWith(".")));
    found.push(...await Promise.all(files.map((entry) => new Promise((/** @type {(file: File) => void} */ done, failed) => entry.file(done, failed)))));
  }
}

export class Files {
  /** @param {{ send: (request: object) => void, problem: (sentence: string) => void, coming: (text: string) => void, transfer: (file: File) => void }} page */
  constructor(page) {
    this.page = page;
    this.raw = new Raw();
    /** @type {XMLHttpRequest | null} */
    this.upload = null;
    /** Name of the volume that is being opened. */
    this.opening = "";
    this.opens = false;
    field("offered").addEventListener("change", () => {
      const name = field("offered").value;
      if (name && !this.isBusy()) this.open({ offered: name }, name);
    });
    element("open-file").addEventListener("click", () => field("volume-file").click());
    field("volume-file").addEventListener("change", () => {
      const files = [...field("volume-file").files ?? []];
      field("volume-file").value = "";
      this.take(files, "");
    });
    element("upload-cancel").addEventListener("click", () => this.cancel());
    addEventListener("dragover", (event) => {
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    addEventListener("dragleave", (event) => {
      if (event.relatedTarget === null) document.body.classList.remove("dropping");
    });
    addEventListener("drop", (event) => {
      event.preventDefault();
      document.body.classList.remove("dropping");
      const { items, files } = /** @type {DataTransfer} */ (event.dataTransfer);
      const folder = items.length === 1 ? items[0].webkitGetAsEntry?.() : null;
      if (folder?.isDirectory) inFolder(/** @type {FileSystemDirectoryEntry} */ (folder)).then((found) => this.take(found, folder.name));
      else this.take([...files], "");
    });
  }

  /** What the server opens, and what it shows.
   * @param {{ opens_volumes: boolean, offered: { name: string, is_builtin: boolean }[] }} hello @param {string} shown */
  set({ opens_volumes: opens, offered }, shown) {
    this.opens = opens;
    element("volume-part").hidden = !opens;
    const option = (/** @type {string} */ value, /** @type {string} */ text) => {
      const made = document.createElement("option");
      [made.value, made.textContent] = [value, text];
      return made;
    };
    const group = (/** @type {string} */ label, /** @type {boolean} */ isBuiltin) => {
      const made = document.createElement("optgroup");
      made.label = label;
      made.append(...offered.filter(({ is_builtin: is }) => is === isBuiltin).map(({ name }) => option(name, name.replace("builtin:", ""))));
      return made;
    };
    element("offered-line").hidden = offered.length === 0;
    const groups = [group("Built in", true), group("In the folder", false)].filter((made) => made.childElementCount > 0);
    field("offered").replaceChildren(option("", "choose …"), ...groups);
    this.shown = shown;
    this.end();
  }

  /** @param {object} volume @param {string} name */
  open(volume, name) {
    this.opening = name;
    this.say(`opening ${name} …`, null, true);
    this.page.send({ type: "open", volume });
  }

  /** How far the volume is that is being opened. @param {{ stage: string, done: number | null }} progress */
  progress({ stage, done }) {
    if (stage === "cancelled" || stage === "failed") this.end();
    else if (this.opening) this.say(`opening ${this.opening}: ${STAGES[stage]}${done === null ? "" : `, ${Math.floor(100 * done)} %`} …`, done, true);
  }

  /** Nothing is on its way any more: the volume is there, or is not to be had. */
  end() {
    this.opening = "";
    element("upload").hidden = this.upload === null;
    element("volume-state").textContent = "";
    this.page.coming("");
    field("offered").value = this.shown ?? "";
    if (field("offered").value !== this.shown) field("offered").value = "";
  }

  /** Whether a volume is on its way; says so. */
  isBusy() {
    if (!this.upload && !this.opening) return false;
    this.page.problem("Another volume is still on its way. Try again when it is there, or cancel it.");
    return true;
  }

  /** Gives up the volume that is on its way. @returns whether there was one */
  cancel() {
    if (this.upload) this.upload.abort();
    else if (this.opening) this.page.send({ type: "cancel_open" });
    else return false;
    return true;
  }

  /** A volume goes to the server, a transfer function to the editor. @param {File[]} files several are one volume
   * @param {string} folder its name, if they come from one */
  async take(files, folder) {
    const [file] = files;
    if (!file) return;
    if (files.length === 1 && TRANSFERS.test(file.name)) {
      this.page.transfer(file);
      return;
    }
    if (!this.opens) {
      this.page.problem("Only files of transfer functions can be dropped here.");
      return;
    }
    if (this.isBusy()) return;
    const isOne = files.length === 1;
    const one = isOne ? await this.raw.named(file) : { name: folder || file.name.replace(/\.[^.]*$/, ""), layout: null };
    if (one === null) return;
    const { name, layout } = one;
    const named = files.map((each) => ({ file: each, name: isOne ? name : each.name }));
    const number = await this.sendAll(named, name, isOne ? "" : `&in=${encodeURIComponent(name)}`);
    if (number !== null) this.open(layout ? { raw: { dropped: number, layout } } : { dropped: number }, name);
  }

  /** Sends the files of a volume one after another. @param {{ file: File, name: string }[]} files @param {string} shown
   * @param {string} query where they belong @returns {Promise<number | null>} the number of the drop */
  async sendAll(files, shown, query) {
    const all = files.reduce((sum, { file }) => sum + file.size, 0);
    const mega = (/** @type {number} */ bytes) => Math.round(bytes / 1e6);
    /** @type {number | null} */
    let number = null;
    let before = 0;
    for (const { file, name } of files) {
      const progress = (/** @type {number} */ sent) => this.say(`sending ${shown}: ${mega(sent)} of ${mega(all)} MB`, sent / Math.max(all, 1), false);
      const start = before;
      progress(start);
      /** @type {string} */
      const address = `/drop?name=${encodeURIComponent(name)}${query}${number === null ? "" : `&to=${number}`}`;
      number = await this.send(file, address, (loaded) => progress(start + loaded));
      if (number === null) break;
      before += file.size;
    }
    this.end();
    return number;
  }

  /** @param {File} file @param {string} address @param {(bytes: number) => void} progress @returns {Promise<number | null>} the number of the drop */
  send(file, address, progress) {
    const upload = new XMLHttpRequest();
    this.upload = upload;
    upload.upload.addEventListener("progress", ({ loaded }) => progress(loaded));
    upload.addEventListener("error", () => this.page.problem("The file did not arrive, because the connection is lost. Drop it again."));
    upload.addEventListener("abort", () => this.page.problem("The file was not sent."));
    return new Promise((done) => {
      upload.addEventListener("loadend", () => {
        this.upload = null;
        if (upload.status !== 200 && upload.status > 0) this.page.problem(upload.responseText || "The server did not take the file.");
        done(upload.status === 200 ? Number(upload.responseText) : null);
      });
      upload.open("POST", address);
      upload.send(file);
    });
  }

  /** @param {string} text @param {number | null} done from 0 to 1, if it is known @param {boolean} isComing whether the volume is about to be shown */
  say(text, done, isComing) {
    element("upload").hidden = false;
    const bar = element("upload-progress");
    if (done === null) bar.removeAttribute("value");
    else bar.setAttribute("value", String(done));
    element("volume-state").textContent = text;
    if (isComing) this.page.coming(text);
  }
}
