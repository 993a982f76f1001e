// Raw files: their name states size and type, or the user does.

/** @param {string} id */
const field = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

/** Bytes of a number by its type. @type {Record<string, number>} */
const BYTES = { uint8: 1, int8: 1, uint16: 2, int16: 2, uint32: 4, int32: 4, float32: 4, float64: 8 };
/** A name of raw voxels, and one that states their size and type. */
const RAW = /\.raw(\.gz)?$/i;
const STATED = /(^|_)\d+x\d+x\d+_u?(int|float)\d+(_|\.raw)/i;

export class Raw {
  constructor() {
    this.dialog = /** @type {HTMLDialogElement} */ (document.getElementById("raw"));
    this.bytes = 0;
    for (const id of ["raw-dims", "raw-type"]) field(id).addEventListener("input", () => this.check());
  }

  /** The name under which a file is sent, with the size that the user states; `null` if the user does not. @param {File} file
   * @returns {Promise<string | null>} */
  async named({ name, size }) {
    if (!RAW.test(name) || STATED.test(name)) return name;
    // The size of a packed file says nothing.
    this.bytes = /\.gz$/i.test(name) ? 0 : size;
    field("raw-file").textContent = `${name} does not state size and type: ${size.toLocaleString("en")} bytes.`;
    this.check();
    this.dialog.returnValue = "";
    this.dialog.showModal();
    await new Promise((done) => this.dialog.addEventListener("close", done, { once: true }));
    if (this.dialog.returnValue !== "open") return null;
    const at = name.search(RAW);
    return `${name.slice(0, at)}_${this.dims.join("x")}_${field("raw-type").value}${name.slice(at)}`;
  }

  get dims() {
    return field("raw-dims").value.split(/[x×,]/).map(Number);
  }

  /** Compares the size with that of the file. */
  check() {
    const { dims, bytes } = this;
    const wanted = dims.reduce((product, n) => product * n, 1) * BYTES[field("raw-type").value];
    const isWrong = bytes > 0 && dims.length === 3 && wanted !== bytes;
    const sentence = isWrong ? `These are ${wanted.toLocaleString("en")} bytes, and the file has ${bytes.toLocaleString("en")}.` : "";
    field("raw-size").textContent = sentence;
    field("raw-dims").setCustomValidity(sentence);
  }
}
