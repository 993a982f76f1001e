// The viewer's page in the cell of a notebook. Its modules run unchanged: what they take for the browser's tab is what this module gives them,
// a shadow root for the document, and the widget's channel for the WebSocket.

/**
 * @typedef {{ get: (name: string) => any, on: (name: string, handler: (...args: any[]) => void) => void,
 *   off: (name: string, handler: (...args: any[]) => void) => void, send: (content: object) => void }} Model of anywidget
 * @typedef {Record<string, unknown>} Surroundings the globals that the page's modules see
 */

/** Milliseconds without an answer after which the kernel is asked whether it hears, and after which it is said to be busy. */
const PATIENCE = 1000;
/** Width of the opened panel in pixels, as in style.css. */
const PANEL = 330;

/** The module of anywidget. @param {{ body: string, style: string, page: (surroundings: Surroundings) => void }} parts of the page */
export const widget = ({ body, style, page }) => ({
  /** Shows a page in an element. @param {{ model: Model, el: HTMLElement }} view @returns what ends it */
  render({ model, el }) {
    const ended = new AbortController();
    const host = document.createElement("div");
    host.className = "layersplat";
    // The right button is the page's.
    el.dataset.jpSuppressContextMenu = "true";
    el.append(host);
    const root = host.attachShadow({ mode: "open" });
    const tab = document.createElement("div");
    tab.className = "page";
    root.innerHTML = `<style>${style}</style>`;
    tab.innerHTML = `${body}<p id="busy" role="status" hidden>The kernel runs a cell, or has ended. The picture follows when it answers.</p>`;
    root.append(tab);
    const find = (/** @type {string} */ id) => /** @type {HTMLElement} */ (root.getElementById(id));
    find("copy").textContent = "Copy as Python";
    find("copy").title = "Copy the Python code that makes this picture (c)";

    const resize = () => {
      const [width, height] = model.get("size");
      tab.style.setProperty("--width", `${width}px`);
      tab.style.setProperty("--panel-width", `${PANEL}px`);
      tab.style.height = `${height}px`;
    };
    resize();
    model.on("change:size", resize);
    const still = hideStill(model.get("still"));
    const theme = followTheme(host, ended.signal);
    // A notebook would add and delete cells by the letters that are typed here. Its shortcuts with Ctrl, for saving, stay.
    tab.addEventListener("keydown", (event) => { if (!event.ctrlKey && !event.metaKey) event.stopPropagation(); });
    // The wheel scrolls the notebook until the picture is clicked.
    tab.addEventListener("wheel", (event) => {
      if (event.target === find("picture") && root.activeElement !== event.target) event.stopPropagation();
    }, { capture: true });

    const channel = new Channel(model, (isBusy) => { find("busy").hidden = !isBusy; });
    page(surroundings(root, tab, host, theme, channel, ended.signal));
    return () => {
      channel.close();
      model.off("change:size", resize);
      ended.abort();
      still.remove();
      host.remove();
    };
  },
});

/** Hides the still picture that stands before the widget, as long as this page is there. @param {string} name */
function hideStill(name) {
  const rule = document.createElement("style");
  const still = `.${CSS.escape(name)}`;
  rule.textContent = `${still}, .jp-OutputArea-child:has(${still}) { display: none !important; }`;
  document.head.append(rule);
  return rule;
}

/** Whether the notebook is dark: by its theme where it has one, otherwise by the system. Sets the attribute `dark`.
 * @param {HTMLElement} host @param {AbortSignal} signal */
function followTheme(host, signal) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const theme = Object.assign(new EventTarget(), { matches: false });
  const update = () => {
    const { jpThemeLight, vscodeThemeKind } = document.body.dataset;
    theme.matches = jpThemeLight ? jpThemeLight === "false" : vscodeThemeKind ? !vscodeThemeKind.includes("light") : system.matches;
    host.toggleAttribute("dark", theme.matches);
    theme.dispatchEvent(new Event("change"));
  };
  update();
  const observer = new MutationObserver(update);
  observer.observe(document.body, { attributes: true, attributeFilter: ["data-jp-theme-light", "data-vscode-theme-kind"] });
  system.addEventListener("change", update, { signal });
  signal.addEventListener("abort", () => observer.disconnect());
  return theme;
}

/** What the page's modules see: the tab's globals, with those replaced that would reach beyond the cell.
 * @param {ShadowRoot} root @param {HTMLElement} tab @param {HTMLElement} host @param {EventTarget} theme @param {Channel} channel
 * @param {AbortSignal} signal @returns {Surroundings} */
function surroundings(root, tab, host, theme, channel, signal) {
  /** An object like another one with some properties of its own. @param {any} real @param {Record<string, any>} own */
  const like = (real, own) => new Proxy({}, {
    get(_, name) {
      if (typeof name === "string" && name in own) return own[name];
      const value = real[name];
      return typeof value === "function" && !/^[A-Z]/.test(String(name)) ? value.bind(real) : value;
    },
    // The title, for example, is the notebook's.
    set: () => true,
  });
  /** Keys, and what is dropped or pasted, are those of the cell. There is no address. @type {typeof globalThis.addEventListener} */
  const addEventListener = (/** @type {string} */ kind, /** @type {any} */ handler, /** @type {any} */ options) => {
    if (kind === "hashchange" || kind === "popstate") return;
    const isOfCell = /^(key|drag|drop|paste|copy|cut)/.test(kind);
    const given = typeof options === "object" ? options : { capture: Boolean(options) };
    (isOfCell ? tab : globalThis).addEventListener(kind, handler, { ...given, signal });
  };
  const location = { hash: "", host: "", pathname: "", search: "", href: "" };
  const own = {
    addEventListener,
    location,
    innerWidth: tab.clientWidth,
    innerHeight: tab.clientHeight,
    history: { state: null, replaceState() {}, pushState() {} },
    matchMedia: (/** @type {string} */ query) => (query.includes("color-scheme") ? theme : matchMedia(query)),
    WebSocket: channel.socket,
    document: like(document, {
      addEventListener,
      body: tab,
      documentElement: tab,
      getElementById: (/** @type {string} */ id) => root.getElementById(id),
      querySelector: (/** @type {string} */ selector) => root.querySelector(selector),
      querySelectorAll: (/** @type {string} */ selector) => root.querySelectorAll(selector),
      get activeElement() { return root.activeElement; },
    }),
  };
  // What the page shows of itself to tests is found at its element.
  return { ...own, window: like(window, own), globalThis: host };
}

/** The widget's channel, as a WebSocket. Several pages may share a model: each has a name, and takes only what is for it. */
class Channel {
  /** @param {Model} model @param {(isBusy: boolean) => void} busy is told whether the kernel hears */
  constructor(model, busy) {
    this.model = model;
    this.busy = busy;
    this.page = crypto.randomUUID?.() ?? String(Math.random());
    /** The newest state of the program that this page knows. */
    this.revision = 0;
    /** Time of the first request without an answer, and whether the kernel was asked since. @type {number | null} */
    this.since = null;
    this.isAsked = false;
    /** @type {any} */
    this.open = null;
    this.listener = (/** @type {any} */ content, /** @type {DataView[]} */ buffers) => this.receive(content, buffers);
    model.on("msg:custom", this.listener);
    this.timer = setInterval(() => this.check(), PATIENCE / 4);
    const channel = this;
    this.socket = class {
      static CONNECTING = 0;
      static OPEN = 1;
      static CLOSED = 3;

      constructor() {
        this.readyState = 0;
        this.onmessage = (/** @type {{ data: unknown }} */ _) => {};
        this.onclose = (/** @type {{ reason: string }} */ _) => {};
        channel.open = this;
        channel.send({ open: true });
        channel.await();
      }

      /** @param {string} text */
      send(text) {
        channel.send({ text });
        if (text.startsWith('{"type":"view"')) channel.await();
      }

      close() {
        channel.close();
      }
    };
  }

  /** @param {object} content */
  send(content) {
    this.model.send({ page: this.page, revision: this.revision, ...content });
  }

  await() {
    this.since ??= performance.now();
  }

  /** @param {{ page: string, revision: number, text?: string }} content @param {DataView[]} buffers */
  receive({ page, revision, text }, buffers) {
    if (page !== this.page) return;
    this.revision = revision;
    this.since = null;
    this.isAsked = false;
    this.busy(false);
    if (!this.open) return;
    this.open.readyState = 1;
    if (text !== undefined) this.open.onmessage({ data: text });
    for (const { buffer, byteOffset, byteLength } of buffers ?? []) {
      this.open.onmessage({ data: buffer.slice(byteOffset, byteOffset + byteLength) });
    }
  }

  /** A kernel that only draws slowly answers when it is asked. */
  check() {
    if (this.since === null) return;
    const waited = performance.now() - this.since;
    if (waited > PATIENCE && !this.isAsked) {
      this.isAsked = true;
      this.send({ asks: true });
    }
    if (waited > 2 * PATIENCE) this.busy(true);
  }

  close() {
    clearInterval(this.timer);
    this.model.off("msg:custom", this.listener);
    this.send({ closed: true });
    this.open = null;
  }
}
