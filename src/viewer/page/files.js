// Other volumes: those that the server offers, and files that are dropped onto the page.

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));
const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (element(id));

/** Ends of the names of transfer functions; other files are volumes. */
const TRANSFERS = /\.(json|vp|csv)$/i;

export class Files {
  /** @param {{ send: (request: object) => void, problem: (sentence: string) => void, transfer: (file: File) => void }} page */
  constructor(page) {
    this.page = page;
    /** @type {XMLHttpRequest | null} */
    this.upload = null;
    this.opens = false;
    field("offered").addEventListener("change", () => {
      const name = field("offered").value;
      if (name) this.open({ offered: name }, name);
    });
    element("open-file").addEventListener("click", () => field("volume-file").click());
    field("volume-file").addEventListener("change", () => {
      const file = field("volume-file").files?.[0];
      field("volume-file").value = "";
      if (file) this.take(file);
    });
    element("upload-cancel").addEventListener("click", () => this.upload?.abort());
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
      const files = [...event.dataTransfer?.files ?? []];
      if (files.length > 1) this.page.problem("Drop one file at a time. Folders and volumes of several files open with the command.");
      else if (files.length === 1) this.take(files[0]);
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
    field("offered").value = shown;
    if (field("offered").value !== shown) field("offered").value = "";
    this.say("");
  }

  /** @param {object} volume @param {string} name */
  open(volume, name) {
    this.say(`${name} is being opened.`);
    this.page.send({ type: "open", volume });
  }

  /** A volume goes to the server, a transfer function to the editor. @param {File} file */
  take(file) {
    if (TRANSFERS.test(file.name)) {
      this.page.transfer(file);
      return;
    }
    if (!this.opens) {
      this.page.problem("Only files of transfer functions can be dropped here.");
      return;
    }
    if (this.upload) {
      this.page.problem("Another file is still on its way. Drop this one again when it is there.");
      return;
    }
    const upload = new XMLHttpRequest();
    this.upload = upload;
    upload.upload.addEventListener("progress", ({ loaded, total }) => {
      field("upload-progress").value = String(loaded / Math.max(total, 1));
      this.say(`${file.name}: ${Math.round(loaded / 1e6)} of ${Math.round(total / 1e6)} MB`);
    });
    upload.addEventListener("load", () => {
      if (upload.status === 200) this.open({ dropped: Number(upload.responseText) }, file.name);
      else this.page.problem(upload.responseText || "The server did not take the file.");
    });
    upload.addEventListener("error", () => this.page.problem("The file did not arrive, because the connection is lost. Drop it again."));
    upload.addEventListener("abort", () => this.page.problem("The file was not sent."));
    upload.addEventListener("loadend", () => {
      this.upload = null;
      element("upload").hidden = true;
      if (upload.status !== 200) this.say("");
    });
    element("upload").hidden = false;
    this.say(`${file.name} is being sent.`);
    upload.open("POST", `/drop?name=${encodeURIComponent(file.name)}`);
    upload.send(file);
  }

  /** @param {string} text */
  say(text) {
    element("volume-state").textContent = text;
  }
}
