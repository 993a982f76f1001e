// Raw files: their name states size and type, or the user does.

/** @param {string} id */
const field = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

/** Bytes of a number by its type. @type {Record<string, number>} */
const BYTES = { uint8: 1, int8: 1, uint16: 2, int16: 2, uint32: 4, int32: 4, float32: 4, float64: 8 };
/** A name of raw voxels, and the part of one that states their size and type. */
const RAW = /\.raw(\.gz)?$/i;
const STATED = /(^|_)(\d+x\d+x\d+)_(u?int(?:8|16|32)|float(?:32|64))(?=_|\.raw)/i;

/** What is not in the name of a raw file. @typedef {{ big_endian: boolean, header_bytes: number }} Layout */

export class Raw {
  constructor() {
    this.dialog = /** @type {HTMLDialogElement} */ (document.getElementById("raw"));
    this.bytes = 0;
    for (const id of ["raw-dims", "raw-type", "raw-header"]) field(id).addEventListener("input", () => this.check());
  }

  /** The name under which a file is sent, with its size and type, and its layout if it is not the usual one. The user is asked for what the
   * name does not state, and where its size is not that of the file; `null` if he states nothing. @param {File} file
   * @returns {Promise<{ name: string, layout: Layout | null } | null>} */
  async named({ name, size }) {
    if (!RAW.test(name)) return { name, layout: null };
    // The size of a packed file says nothing.
    this.bytes = /\.gz$/i.test(name) ? 0 : size;
    const [stated, before, dims, type] = STATED.exec(name) ?? [];
    if (stated && (this.bytes === 0 || bytesOf(dims, type) === size)) return { name, layout: null };
    const found = `${size.toLocaleString("en")} bytes`;
    field("raw-file").textContent = stated ? `${name} has ${found}.` : `${name} does not state size and type: ${found}.`;
    if (stated) [field("raw-dims").value, field("raw-type").value] = [dims, type.toLowerCase()];
    [field("raw-header").value, field("raw-order").value] = ["0", "little"];
    this.check();
    this.dialog.returnValue = "";
    this.dialog.showModal();
    await new Promise((done) => this.dialog.addEventListener("close", done, { once: true }));
    if (this.dialog.returnValue !== "open") return null;
    const parts = `${dimsOf(field("raw-dims").value).join("x")}_${field("raw-type").value}`;
    const layout = { big_endian: field("raw-order").value === "big", header_bytes: Number(field("raw-header").value) };
    return {
      name: stated ? name.replace(STATED, before + parts) : name.replace(RAW, (end) => `_${parts}${end}`),
      layout: layout.big_endian || layout.header_bytes > 0 ? layout : null,
    };
  }

  /** Compares the size with that of the file. */
  check() {
    const wanted = bytesOf(field("raw-dims").value, field("raw-type").value) + Number(field("raw-header").value);
    const isWrong = this.bytes > 0 && wanted !== this.bytes;
    const [stated, found] = [wanted, this.bytes].map((bytes) => bytes.toLocaleString("en"));
    const sentence = isWrong && wanted > 0 ? `These are ${stated} bytes, and the file has ${found}.` : "";
    field("raw-size").textContent = sentence;
    field("raw-dims").setCustomValidity(sentence);
  }
}

/** @param {string} text */
const dimsOf = (text) => text.split(/[x×,]/i).map(Number);

/** Bytes of voxels; not a number unless three sizes are stated. @param {string} dims @param {string} type */
function bytesOf(dims, type) {
  const sizes = dimsOf(dims);
  return sizes.length === 3 ? sizes.reduce((product, n) => product * n, 1) * BYTES[type.toLowerCase()] : NaN;
}
