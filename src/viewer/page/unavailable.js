// What the page cannot do with the fields that it shows: the server says why, and the page offers it no more.

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** Controls by the server's names: ids, and options of lists. @type {Record<string, string[]>} */
const CONTROLS = {
  shadows: ["shadows", "shadow-strength"],
  "ambient-occlusion": ["ambient-occlusion"],
  studio: ["lit=studio"],
  slices: ["shown", "planes", "colors", "kernel", "level", "width", "thickness", "x", "y", "z"].map((name) => `slices-${name}`),
  paper: ["quality=paper"],
  maximum: ["blend=maximum"],
  minimum: ["blend=minimum"],
  average: ["blend=average"],
  iso: ["blend=iso"],
};

/** Titles before a reason took their place. @type {Map<HTMLElement, string>} */
const titles = new Map();

/** @param {HTMLElement} carrier @param {string | undefined} reason */
function explain(carrier, reason) {
  if (!titles.has(carrier)) titles.set(carrier, carrier.title);
  carrier.title = reason ?? titles.get(carrier) ?? "";
}

/** Shadows are enabled by the light's controls. @param {Record<string, string>} unavailable reasons by name */
export function show(unavailable) {
  for (const [name, ids] of Object.entries(CONTROLS)) {
    const reason = unavailable[name];
    for (const id of ids) {
      const [list, value] = id.split("=");
      const control = /** @type {HTMLInputElement} */ (value ? element(list).querySelector(`option[value=${value}]`) : element(id));
      if (reason !== undefined) control.disabled = true;
      else if (value || name === "slices") control.disabled = false;
      explain(value ? control : control.closest("label") ?? control, reason);
    }
  }
  const curve = element("curve-part");
  for (const part of [...curve.children].slice(1)) /** @type {HTMLElement} */ (part).inert = "curve" in unavailable;
  explain(curve, unavailable.curve);
}
