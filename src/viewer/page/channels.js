// The list of channels, or of labels: names, colours and visibility.

import { fromHex, toHex } from "./editing.js";

/** @typedef {import("./state.js").Look} Look */
/** @typedef {import("./state.js").Transfer} Transfer */
/** @typedef {{ key: string, id: number, name: string, color: number[], visible: boolean, voxels: number }} Label */

/** Labels from which on a list can be searched. */
const MANY = 12;
/** Ends of the sliders: powers of ten. */
const LARGEST_POWER = 2;

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
/** @param {string} kind @param {Record<string, string>} [attributes] */
const input = (kind, attributes = {}) => Object.assign(document.createElement("input"), { type: kind, ...attributes });

/** The colours of a transfer function as shades of one colour, as bright as they were. @param {Transfer} transfer @param {string} color `#rrggbb` */
export function shaded({ name, colors, opacities }, color) {
  const brightest = Math.max(...colors.map(([, rgb]) => Math.max(...rgb))) || 1;
  const shade = (/** @type {number[]} */ rgb) => fromHex(color).map((c) => (c * Math.max(...rgb)) / brightest);
  return /** @type {Transfer} */ ({ name, opacities, colors: colors.map(([x, rgb]) => [x, shade(rgb)]) });
}

/** Which labels are visible. @param {Label[]} labels @param {Look["labels"]} changes */
export function visibleKeys(labels, { only, hidden }) {
  const isShown = (/** @type {Label} */ { key, visible }) => (only.length > 0 ? only.includes(key) : visible) && !hidden.includes(key);
  return new Set(labels.filter(isShown).map(({ key }) => key));
}

/** The shorter list that makes these labels visible. @param {Label[]} labels @param {Set<string>} visible */
export function changesFor(labels, visible) {
  const first = new Set(labels.filter((label) => label.visible).map(({ key }) => key));
  const hidden = [...first].filter((key) => !visible.has(key));
  const isHiding = [...visible].every((key) => first.has(key));
  if (visible.size === 0 || (isHiding && hidden.length <= visible.size)) return { only: [], hidden };
  return { only: [...visible], hidden: [] };
}

export class Channels {
  /** @param {{ change: (change: (look: Look) => void, isDone: boolean) => void, choose: (field: number) => void,
   *   recolor: (field: number, color: string, isDone: boolean) => void }} page */
  constructor(page) {
    this.page = page;
    /** @type {Label[]} */
    this.labels = [];
    /** What each row shows. @type {((look: Look) => void)[]} */
    this.rows = [];
    element("field").addEventListener("change", (event) => page.choose(Number(/** @type {HTMLSelectElement} */ (event.target).value)));
    element("labels-all").addEventListener("click", () => this.setVisible(() => true));
    element("labels-none").addEventListener("click", () => this.setVisible(() => false));
    element("labels-search").addEventListener("input", () => this.search());
  }

  /** @param {{ channels: { name: string }[], labels: Label[] }} hello */
  begin({ channels, labels }) {
    this.labels = labels;
    const isSeveral = channels.length > 1;
    element("channels-part").hidden = channels.length === 0 && labels.length === 0;
    element("channels-title").textContent = labels.length > 0 ? "Labels" : "Channels";
    element("labels-buttons").hidden = labels.length === 0;
    element("labels-search").hidden = labels.length < MANY;
    element("field-line").hidden = !isSeveral;
    element("field").replaceChildren(...channels.map(({ name }, n) => new Option(name, String(n))));
    this.rows = [];
    element("channels").replaceChildren(...channels.map(({ name }, n) => this.channelRow(name, n)), ...labels.map((label) => this.labelRow(label)));
    element("channels").classList.toggle("labels", labels.length > 0);
  }

  /** @param {Look} look @param {number} field the one whose curve is edited */
  show(look, field) {
    this.look = look;
    this.visible = visibleKeys(this.labels, look.labels);
    /** @type {HTMLSelectElement} */ (element("field")).value = String(field);
    for (const show of this.rows) show(look);
  }

  /** @param {string} name @param {number} n */
  channelRow(name, n) {
    const visible = input("checkbox");
    const color = input("color", { ariaLabel: `Colour of ${name}` });
    const slider = input("range", { min: String(-LARGEST_POWER), max: String(LARGEST_POWER), step: "0.01", ariaLabel: `Factor of ${name}` });
    const factor = input("number", { min: "0", step: "any", ariaLabel: `Factor of ${name}, number` });
    slider.title = factor.title = "Factor of the extinction";
    const set = (/** @type {number} */ value, /** @type {boolean} */ isDone) => {
      if (Number.isFinite(value) && value >= 0) this.page.change((look) => { look.channels[n].factor = value; }, isDone);
    };
    const ofSlider = () => Number((10 ** slider.valueAsNumber).toPrecision(3));
    visible.addEventListener("change", () => this.page.change((look) => { look.channels[n].visible = visible.checked; }, true));
    color.addEventListener("input", () => this.page.recolor(n, color.value, false));
    color.addEventListener("change", () => this.page.recolor(n, color.value, true));
    slider.addEventListener("input", () => set(ofSlider(), false));
    slider.addEventListener("change", () => set(ofSlider(), true));
    factor.addEventListener("change", () => set(factor.valueAsNumber, true));
    this.rows.push(({ channels }) => {
      const shown = channels[n];
      visible.checked = shown.visible;
      color.value = shown.color;
      slider.value = String(shown.factor > 0 ? Math.log10(shown.factor) : -LARGEST_POWER);
      if (factor !== document.activeElement) factor.value = String(shown.factor);
    });
    return row(named(visible, name), color, slider, factor);
  }

  /** @param {Label} label */
  labelRow({ key, id, name, color: first, voxels }) {
    const visible = input("checkbox");
    const color = input("color", { ariaLabel: `Colour of ${name}` });
    const only = Object.assign(document.createElement("button"), { type: "button", textContent: "Only", title: "Show this label alone", ariaLabel: `Only ${name}` });
    visible.addEventListener("change", () => this.setVisible((other) => (other === key ? visible.checked : this.isVisible(other))));
    only.addEventListener("click", () => this.setVisible((other) => other === key));
    const recolor = (/** @type {boolean} */ isDone) => () => this.page.change((look) => {
      const others = look.labels.colors.filter(([other]) => other !== key);
      look.labels.colors = color.value === toHex(first) ? others : [...others, [key, color.value]];
    }, isDone);
    color.addEventListener("input", recolor(false));
    color.addEventListener("change", recolor(true));
    this.rows.push(({ labels }) => {
      visible.checked = this.isVisible(key);
      color.value = labels.colors.find(([other]) => other === key)?.[1] ?? toHex(first);
    });
    const made = row(named(visible, name), color, only);
    made.title = `label ${id}, ${voxels} voxels`;
    return made;
  }

  /** @param {string} key */
  isVisible(key) {
    return this.visible?.has(key) ?? true;
  }

  /** @param {(key: string) => boolean} isVisible */
  setVisible(isVisible) {
    const visible = new Set(this.labels.map(({ key }) => key).filter(isVisible));
    this.page.change((look) => { look.labels = { ...look.labels, ...changesFor(this.labels, visible) }; }, true);
  }

  search() {
    const text = /** @type {HTMLInputElement} */ (element("labels-search")).value.toLowerCase();
    [...element("channels").children].forEach((made, n) => {
      const { name, id } = this.labels[n];
      /** @type {HTMLElement} */ (made).hidden = !name.toLowerCase().includes(text) && String(id) !== text;
    });
  }
}

/** @param {HTMLInputElement} box @param {string} name */
function named(box, name) {
  const label = document.createElement("label");
  label.className = "check";
  label.title = name;
  const text = document.createElement("span");
  text.textContent = name;
  label.append(box, text);
  return label;
}

/** @param {HTMLElement[]} parts */
function row(...parts) {
  const made = document.createElement("li");
  made.append(...parts);
  return made;
}
