// Blend mode, quality, kernel, gradients, background, and what is drawn over the picture.

/** @typedef {import("./state.js").Look} Look */

/** @param {string} id */
const element = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

/** What lists show for names that need it. @type {Record<string, string>} */
const LABELS = {
  iso: "iso-surface", "catmull-rom": "Catmull–Rom", bspline: "B-spline",
  central: "central differences", sobel: "Sobel", "gaussian:1": "Gaussian", own: "of the kernel",
};

/** Fills lists with the names that the program knows. @param {Record<string, string[]>} choices by the list's id */
export function fill(choices) {
  for (const [id, names] of Object.entries(choices)) {
    const list = /** @type {HTMLSelectElement} */ (/** @type {unknown} */ (element(id)));
    // The first option, without a value, is the default.
    const first = [...list.options].filter(({ value }) => value === "");
    list.replaceChildren(...first, ...names.map((name) => new Option(LABELS[name] ?? name, name)));
  }
}

/** @typedef {{ name: string, help: string, default: unknown, names: string[] | null, range: number[] | null }} Setting */

/** Settings that have a control because the program describes them. @type {Setting[]} */
let described = [];

/** Makes their controls. @param {Setting[]} settings @param {(change: (look: Look) => void, isDone: boolean) => void} change */
export function make(settings, change) {
  described = settings;
  element("plain").replaceChildren(...settings.map((setting) => {
    const { name, help, names, range } = setting;
    const label = document.createElement("label");
    const control = /** @type {HTMLInputElement} */ (document.createElement(names ? "select" : "input"));
    control.id = `setting-${name}`;
    if (names) control.append(...names.map((choice) => new Option(choice, choice)));
    else if (range) Object.assign(control, { type: "number", step: "any", min: String(range[0]), max: String(range[1]) });
    else control.type = "checkbox";
    const words = name[0].toUpperCase() + name.slice(1).replaceAll("_", " ");
    const isCheck = control.type === "checkbox";
    [label.title, label.className] = [help, isCheck ? "check" : "line"];
    label.append(...(isCheck ? [control, words] : [words, control]));
    control.addEventListener("change", () => {
      if (!control.checkValidity()) return;
      const number = Number.isFinite(control.valueAsNumber) ? control.valueAsNumber : setting.default;
      const value = isCheck ? control.checked : range ? number : control.value;
      change((look) => {
        if (value === setting.default) delete look.plain[name];
        else look.plain[name] = value;
      }, true);
    });
    return label;
  }));
}

/** @param {Look} look */
function showDescribed(look) {
  for (const setting of described) {
    const [control, value] = [element(`setting-${setting.name}`), look.plain[setting.name] ?? setting.default];
    if (control.type === "checkbox") control.checked = value === true;
    else if (control !== document.activeElement || control.type !== "number") control.value = String(value ?? "");
  }
}

/** @param {(change: (look: Look) => void, isDone: boolean) => void} change */
export function listen(change) {
  const choose = (/** @type {string} */ id, /** @type {(look: Look, value: string) => void} */ set) => {
    element(id).addEventListener("change", () => change((look) => set(look, element(id).value), true));
  };
  choose("blend", (look, value) => { look.blend = value; });
  choose("quality", (look, value) => {
    look.quality = value || null;
    // The paper's splats have their own kernel.
    if (value === "paper") look.kernel = null;
  });
  choose("kernel", (look, value) => { look.kernel = value || null; });
  choose("gradient", (look, value) => { look.gradient = value || null; });
  for (const [id, name] of /** @type {const} */ ([["legend", "legend"], ["bounding-box", "bounding_box"], ["axes", "axes"]])) {
    element(id).addEventListener("change", () => change((look) => { look[name] = element(id).checked; }, true));
  }
  for (const id of ["iso", "iso-number"]) {
    const set = (/** @type {boolean} */ isDone) => {
      const value = element(id).valueAsNumber;
      if (Number.isFinite(value)) change((look) => { look.iso = value; }, isDone);
    };
    if (id === "iso") element(id).addEventListener("input", () => set(false));
    element(id).addEventListener("change", () => set(true));
  }
  element("background").addEventListener("input", () => change((look) => { look.background = element("background").value; }, false));
  element("background").addEventListener("change", () => change((look) => { look.background = element("background").value; }, true));
  element("transparent").addEventListener("change", () => change((look) => {
    look.background = element("transparent").checked ? "transparent" : element("background").value;
  }, true));
}

/** @param {Look} look @param {boolean} isLayered whether the algorithm has qualities and kernels */
export function show(look, isLayered) {
  element("blend").value = look.blend;
  element("quality").value = look.quality ?? "";
  element("kernel").value = look.kernel ?? "";
  element("quality").disabled = !isLayered;
  element("kernel").disabled = !isLayered || look.quality === "paper";
  showGradient(look.gradient);
  showDescribed(look);
  [element("legend").checked, element("bounding-box").checked, element("axes").checked] = [look.legend, look.bounding_box, look.axes];
  element("iso-line").hidden = look.blend !== "iso";
  element("iso").value = String(look.iso);
  if (element("iso-number") !== document.activeElement) element("iso-number").value = String(Number(look.iso.toPrecision(6)));
  element("transparent").checked = look.background === "transparent";
  if (look.background !== "transparent") element("background").value = look.background;
}

/** One that the command was given is in the list, too. @param {string | null} gradient */
function showGradient(gradient) {
  const list = /** @type {HTMLSelectElement} */ (/** @type {unknown} */ (element("gradient")));
  const name = gradient ?? "";
  if (![...list.options].some(({ value }) => value === name)) list.append(new Option(name, name));
  list.value = name;
}

/** @param {number} lowest @param {number} highest */
export function setRange(lowest, highest) {
  [element("iso").min, element("iso").max] = [String(lowest), String(highest)];
}
