// Named transfer functions: automatic ones, presets, and the strips of colour maps; files.

/** @typedef {import("./session.js").Session} Session */

const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

/** @param {Session} session */
export function listen({ connection }) {
  field("load-transfer").addEventListener("click", () => field("transfer-file").click());
  field("transfer-file").addEventListener("change", async () => {
    const file = field("transfer-file").files?.[0];
    field("transfer-file").value = "";
    if (file) connection.send({ type: "read", name: file.name, text: await file.text() });
  });
  field("save-transfer").addEventListener("change", () => {
    const format = field("save-transfer").value;
    field("save-transfer").value = "";
    if (format) connection.send({ type: "write", name: `layersplat.${format}` });
  });
  field("named").addEventListener("change", () => {
    const [kind, name] = field("named").value.split(":");
    field("named").value = "";
    if (kind) connection.send({ type: "named", kind, name });
  });
}

/** The list of named transfer functions, and the strips of colour maps. @param {Session} session */
export function fill(session) {
  const { palettes, presets, maps } = session.hello;
  const option = (/** @type {string} */ value, /** @type {string} */ text) => {
    const item = document.createElement("option");
    [item.value, item.textContent] = [value, text];
    return item;
  };
  const group = (/** @type {string} */ label, /** @type {HTMLOptionElement[]} */ items) => {
    const part = document.createElement("optgroup");
    part.label = label;
    part.append(...items);
    return part;
  };
  field("named").replaceChildren(
    option("", "choose …"),
    option("initial:", "as at the start"),
    group("Automatic, in colours", palettes.map((/** @type {string} */ name) => option(`automatic:${name}`, name))),
    group("Presets", presets.map((/** @type {any} */ { name, shows }) => option(`preset:${name}`, `${name} – ${shows}`))),
  );
  field("maps").replaceChildren(...maps.map((/** @type {any} */ map) => swatch(map, session)));
}

/** A button with the colours of a map, which keeps the opacities. @param {{ name: string, colors: number[][] }} map @param {Session} session */
function swatch({ name, colors }, session) {
  const [button, canvas] = [document.createElement("button"), document.createElement("canvas")];
  button.type = "button";
  button.title = button.ariaLabel = name;
  [canvas.width, canvas.height] = [46, 20];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const gradient = context.createLinearGradient(0, 0, canvas.width, 0);
  colors.forEach((rgb, n) => gradient.addColorStop(n / Math.max(colors.length - 1, 1), `rgb(${rgb.map((c) => Math.round(c * 255)).join(" ")})`));
  context.fillStyle = gradient;
  context.fillRect(0, 0, canvas.width, canvas.height);
  button.append(canvas);
  button.addEventListener("click", () => {
    const { opacities } = session.state.transfer;
    const values = opacities.filter(([, opacity]) => opacity > 0).map(([value]) => value);
    const { lowest, highest } = session.hello.histogram;
    const [low, high] = values.length > 1 ? [Math.min(...values), Math.max(...values)] : [lowest, highest];
    const end = Math.max(colors.length - 1, 1);
    session.setTransfer({ name, opacities, colors: colors.map((rgb, n) => [low + ((high - low) * n) / end, [...rgb]]) });
  });
  return button;
}
