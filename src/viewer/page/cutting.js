// Crop box and clip planes, by numbers and sliders.

/** @typedef {import("./state.js").Look} Look */

/** Most clip planes. */
const MOST_CLIPS = 6;
/** Least size of a crop box in voxels. */
const LEAST = 0.5;

/** @param {Partial<HTMLInputElement> & { label: string }} properties */
function input({ label, ...properties }) {
  const field = document.createElement("input");
  Object.assign(field, properties);
  field.setAttribute("aria-label", label);
  return field;
}

export class Cutting {
  /** @param {{ change: (change: (look: Look) => void, isDone: boolean) => void, plane: () => number[] }} page `plane`: a new clip plane */
  constructor(page) {
    this.page = page;
    this.dims = [1, 1, 1];
    /** @type {HTMLInputElement[][]} sliders and numbers: lowest and highest of each axis */
    this.fields = [];
    /** World size, for the steps of clip planes. */
    this.diagonal = 1;
    document.getElementById("uncrop")?.addEventListener("click", () => page.change((look) => { look.crop = null; }, true));
    document.getElementById("add-clip")?.addEventListener("click", () => {
      page.change((look) => { if (look.clips.length < MOST_CLIPS) look.clips.push(page.plane()); }, true);
    });
  }

  /** @param {{ dims: number[], diagonal: number }} volume */
  setVolume({ dims, diagonal }) {
    [this.dims, this.diagonal] = [dims, diagonal];
    const crop = /** @type {HTMLElement} */ (document.getElementById("crop"));
    crop.replaceChildren();
    this.fields = [];
    ["x", "y", "z"].forEach((name, axis) => {
      for (const [end, what] of [[0, "from"], [1, "to"]]) {
        const row = document.createElement("div");
        row.className = "axis";
        const text = document.createElement("span");
        text.textContent = end === 0 ? name : "";
        const range = { min: "0", max: String(dims[axis] - 1) };
        const slider = input({ label: `${name} ${what}`, type: "range", step: "1", ...range });
        const number = input({ label: `${name} ${what}, number`, type: "number", step: "any", ...range });
        for (const field of [slider, number]) {
          const set = (/** @type {boolean} */ isDone) => this.cropTo(axis, Number(end), field.valueAsNumber, isDone);
          if (field === slider) field.addEventListener("input", () => set(false));
          field.addEventListener("change", () => set(true));
        }
        row.append(text, slider, number);
        crop.append(row);
        this.fields.push([slider, number]);
      }
    });
  }

  get whole() {
    return [[0, 0, 0], this.dims.map((n) => n - 1)];
  }

  /** @param {number} axis @param {number} end @param {number} value @param {boolean} isDone */
  cropTo(axis, end, value, isDone) {
    if (!Number.isFinite(value)) return;
    this.page.change((look) => {
      const crop = look.crop ?? this.whole;
      crop[end][axis] = Math.min(Math.max(value, -1), this.dims[axis]);
      if (crop[1][axis] - crop[0][axis] < LEAST) {
        crop[end][axis] = end === 0 ? crop[1][axis] - LEAST : crop[0][axis] + LEAST;
      }
      look.crop = crop;
    }, isDone);
  }

  /** @param {Look} look */
  set(look) {
    const crop = look.crop ?? this.whole;
    this.fields.forEach((fields, n) => {
      for (const field of fields) {
        if (field !== document.activeElement || field.type === "range") field.value = String(Number(crop[n % 2][n >> 1].toFixed(3)));
      }
    });
    document.getElementById("uncrop")?.toggleAttribute("disabled", look.crop === null);
    document.getElementById("add-clip")?.toggleAttribute("disabled", look.clips.length >= MOST_CLIPS);
    const clips = /** @type {HTMLElement} */ (document.getElementById("clips"));
    // Sliders that a hand holds stay.
    if (clips.childElementCount !== look.clips.length) clips.replaceChildren(...look.clips.map((_, n) => this.clip(n)));
    look.clips.forEach((plane, n) => this.showClip(/** @type {HTMLElement} */ (clips.children[n]), plane));
  }

  /** @param {number} n */
  clip(n) {
    const box = document.createElement("div");
    box.className = "clip";
    const row = () => {
      const line = document.createElement("div");
      line.className = "row";
      return line;
    };
    const [numbers, buttons] = [row(), row()];
    const normals = ["x", "y", "z"].map((name, axis) => {
      const field = input({ label: `Plane ${n + 1}, normal ${name}`, type: "number", step: "any" });
      field.addEventListener("change", () => this.page.change((look) => {
        const normal = look.clips[n].slice(3);
        normal[axis] = field.valueAsNumber;
        if (normal.every(Number.isFinite) && Math.hypot(...normal) > 1e-9) look.clips[n].splice(3, 3, ...normal);
      }, true));
      return field;
    });
    numbers.append("Normal", ...normals);
    const slider = input({ label: `Plane ${n + 1}, along its normal`, type: "range", min: "-1", max: "1", step: "any", value: "0" });
    let held = /** @type {number[] | null} */ (null);
    const slide = (/** @type {boolean} */ isDone) => this.page.change((look) => {
      held ??= look.clips[n].slice(0, 3);
      const normal = look.clips[n].slice(3);
      const far = (slider.valueAsNumber * this.diagonal) / 2 / Math.hypot(...normal);
      look.clips[n].splice(0, 3, ...held.map((p, i) => p + normal[i] * far));
    }, isDone);
    slider.addEventListener("input", () => slide(false));
    slider.addEventListener("change", () => {
      slide(true);
      held = null;
      slider.value = "0";
    });
    const button = (/** @type {string} */ text, /** @type {(look: Look) => void} */ change) => {
      const element = document.createElement("button");
      element.type = "button";
      element.textContent = text;
      element.addEventListener("click", () => this.page.change(change, true));
      return element;
    };
    buttons.append(
      button("Flip", (look) => look.clips[n].splice(3, 3, ...look.clips[n].slice(3).map((x) => (x === 0 ? 0 : -x)))),
      button("Delete", (look) => look.clips.splice(n, 1)),
    );
    box.append(slider, numbers, buttons);
    return box;
  }

  /** @param {HTMLElement} box @param {number[]} plane */
  showClip(box, plane) {
    box.querySelectorAll('input[type="number"]').forEach((field, axis) => {
      if (field !== document.activeElement) /** @type {HTMLInputElement} */ (field).value = String(Number(plane[3 + axis].toFixed(3)));
    });
  }
}
