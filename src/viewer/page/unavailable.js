// What the page cannot do with the fields that it shows: the server says why, and the page offers it no more.

/** Controls by the server's names, and what carries the reason. */
const CONTROLS = {
  shadows: ["#shadows", "#shadow-strength"],
  "ambient-occlusion": ["#ambient-occlusion"],
  slices: ["#slices-shown", "#slices-planes", "#slices-colors", "#slices-kernel", "#slices-level", "#slices-width", "#slices-x", "#slices-y", "#slices-z"],
  paper: ["#quality option[value=paper]"],
  maximum: ["#blend option[value=maximum]"],
  minimum: ["#blend option[value=minimum]"],
  average: ["#blend option[value=average]"],
  iso: ["#blend option[value=iso]"],
  curve: ["#curve-part > :not(summary)"],
};

/** Titles before a reason took their place. @type {Map<HTMLElement, string>} */
const titles = new Map();

/** @param {Record<string, string>} unavailable reasons by name */
export function show(unavailable) {
  for (const [name, selectors] of Object.entries(CONTROLS)) {
    const reason = unavailable[name];
    for (const control of document.querySelectorAll(selectors.join())) {
      const found = /** @type {HTMLInputElement} */ (control);
      if (name === "curve") found.inert = reason !== undefined;
      else if (reason !== undefined) found.disabled = true;
      else if (name === "slices" || found.tagName === "OPTION") found.disabled = false;
      const carrier = name === "curve" ? /** @type {HTMLElement} */ (found.parentElement) : found.closest("label") ?? found;
      if (!titles.has(carrier)) titles.set(carrier, carrier.title);
      carrier.title = reason ?? titles.get(carrier) ?? "";
    }
  }
}
