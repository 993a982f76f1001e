// Named transfer functions, with previews: automatic ones in the colours of palettes, presets, and colour maps; files.

/** @typedef {import("./session.js").Session} Session */
/** @typedef {{ name: string, shows?: string, colors: number[][] }} Named */

/** What is done to choose a transfer function. */
const LOOKING = "looking at the values";

const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

/** @param {Session} session */
export function listen(session) {
  const { connection } = session;
  field("load-transfer").addEventListener("click", () => field("transfer-file").click());
  field("transfer-file").addEventListener("change", async () => {
    const file = field("transfer-file").files?.[0];
    field("transfer-file").value = "";
    if (file) session.ask({ type: "read", field: session.field, name: file.name, text: await file.text() }, LOOKING);
  });
  field("save-transfer").addEventListener("change", () => {
    const format = field("save-transfer").value;
    field("save-transfer").value = "";
    if (format) connection.send({ type: "write", field: session.field, name: `layersplat.${format}` });
  });
  const named = (/** @type {string} */ id, /** @type {() => { kind: string, name: string }} */ what) => {
    field(id).addEventListener("click", () => session.ask({ type: "named", field: session.field, ...what() }, LOOKING));
  };
  named("initial", () => ({ kind: "initial", name: "" }));
  // The first palette is the default.
  named("automatic", () => ({ kind: "automatic", name: session.hello.palettes[0].name }));
}

/** Previews of palettes, presets and colour maps. @param {Session} session */
export function fill(session) {
  const { palettes, presets, maps } = session.hello;
  const ask = (/** @type {string} */ kind) => (/** @type {Named} */ { name }) => session.ask({ type: "named", field: session.field, kind, name }, LOOKING);
  field("palettes").replaceChildren(...palettes.map((/** @type {Named} */ palette) => swatch(palette, ask("automatic"), true)));
  field("presets").replaceChildren(...presets.map((/** @type {Named} */ preset) => swatch(preset, ask("preset"), false)));
  field("maps").replaceChildren(...maps.map((/** @type {Named} */ map) => swatch(map, (chosen) => useMap(chosen, session), false)));
}

/** A button with colours. @param {Named} named @param {(named: Named) => void} choose @param {boolean} isSteps whether colours do not blend */
function swatch(named, choose, isSteps) {
  const { name, shows, colors } = named;
  const button = document.createElement("button");
  button.type = "button";
  button.title = button.ariaLabel = shows ? `${name} – ${shows}` : name;
  button.append(preview(colors, isSteps));
  if (shows) button.append(name);
  button.addEventListener("click", () => choose(named));
  return button;
}

/** @param {number[][]} colors @param {boolean} isSteps */
function preview(colors, isSteps) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [46, 20];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const gradient = context.createLinearGradient(0, 0, canvas.width, 0);
  colors.forEach((rgb, n) => {
    const style = `rgb(${rgb.map((c) => Math.round(c * 255)).join(" ")})`;
    const stops = isSteps ? [n / colors.length, (n + 1) / colors.length] : [n / Math.max(colors.length - 1, 1)];
    for (const stop of stops) gradient.addColorStop(stop, style);
  });
  context.fillStyle = gradient;
  context.fillRect(0, 0, canvas.width, canvas.height);
  return canvas;
}

/** The colours of a map over the values that are visible; opacities stay. @param {Named} map @param {Session} session */
function useMap({ name, colors }, session) {
  const { opacities } = session.transfer;
  const values = opacities.filter(([, opacity]) => opacity > 0).map(([value]) => value);
  const { lowest, highest } = session.histogram;
  const [low, high] = values.length > 1 ? [Math.min(...values), Math.max(...values)] : [lowest, highest];
  const end = Math.max(colors.length - 1, 1);
  session.setTransfer({ name, opacities, colors: colors.map((rgb, n) => [low + ((high - low) * n) / end, [...rgb]]) });
}
