// The page's state, and what the server has of it: requests are made here alone.

import { Connection } from "./connection.js";
import { firstSlices } from "./slices.js";
import { copy, fromFragment, History, isEqual, toFragment } from "./state.js";

/** @typedef {import("./state.js").Camera} Camera */
/** @typedef {import("./state.js").Look} Look */
/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Transfer} Transfer */
/** @typedef {{ say: (sentence: string) => void, show: () => void, showCamera: () => void, showHistory: () => void, showTime: () => void, asked: (what: string) => void,
 *   requested: (own: { id: number, isOther: boolean, transfer: unknown, background: string, isMoving: boolean }) => void }} Shows */

/** Milliseconds after the last key at which the hand rests. */
const KEY_REST = 250;
/** Milliseconds between changes of the address: browsers limit them. */
const ADDRESS_TIME = 300;

export class Session {
  /** @param {import("./picture.js").Picture} picture @param {Shows} shows
   * @param {{ message: (text: any) => void, picture: (received: import("./connection.js").Received) => void, lost: (reason: string, isBad: boolean) => void }} handlers */
  constructor(picture, shows, handlers) {
    this.picture = picture;
    this.shows = shows;
    /** What the server said first. @type {any} */
    this.hello = null;
    /** @type {History | null} */
    this.history = null;
    /** The look and the transfer functions that the server has. */
    this.sent = { look: /** @type {Look | null} */ (null), transfers: /** @type {unknown[]} */ ([]) };
    /** The channel whose transfer function is edited. */
    this.field = 0;
    /** Number of the last requested view. */
    this.id = 0;
    this.isMoving = false;
    /** Whether time runs. */
    this.isPlaying = false;
    /** Number of the first view with the last step. */
    this.stepId = 0;
    /** Whether the next fitted camera is the first view. */
    this.awaits = /** @type {"nothing" | "first" | "fit" | "resized"} */ ("nothing");
    /** What the last fit chose: the view follows sides and sizes as long as it is so. @type {unknown} */
    this.fittedTo = null;
    this.rest = 0;
    this.addressTimer = 0;
    this.connection = new Connection(handlers);
  }

  get state() {
    return /** @type {History} */ (this.history).now;
  }

  /** A new connection: the first one, or one after a loss, with the same view. @param {any} hello */
  begin(hello) {
    if (this.hello && this.hello.scene !== hello.scene) {
      // Another volume: nothing of the last one's state applies.
      this.history = null;
      this.field = 0;
      window.history.replaceState(null, "", location.pathname);
    }
    this.hello = hello;
    // Sent again: what the page sent last may have met the volume before.
    this.sent = { look: null, transfers: [] };
    if (this.history === null) {
      this.history = new History(this.initial);
      const kept = this.fromAddress();
      if (kept) {
        this.history.now = kept;
        this.history.commit();
      } else if (!hello.camera_is_given) {
        this.awaits = "first";
      }
    }
    this.shows.show();
    if (this.awaits === "first") this.fit("first");
    else this.settle();
  }

  /** The state in the address; says if it holds none. */
  fromAddress() {
    const fragment = location.hash.slice(1);
    const kept = fromFragment(fragment, this.initial);
    if (fragment && !kept) this.shows.say("The view in the address is damaged or of another kind of volume: this is the first view.");
    return kept;
  }

  /** The server does not understand the state, which came from the address: the first view instead. */
  forget() {
    this.history = null;
    window.history.replaceState(null, "", location.pathname);
  }

  get initial() {
    const { camera, look, transfer, channels } = this.hello;
    const others = channels.slice(1).map((/** @type {{ transfer: Transfer }} */ channel) => channel.transfer);
    return { camera, look, transfer, others, slices: firstSlices(this.hello) };
  }

  /** The transfer function of the chosen channel. @returns {Transfer} */
  get transfer() {
    return this.field === 0 ? this.state.transfer : this.state.others[this.field - 1];
  }

  set transfer(transfer) {
    this.put(this.field, transfer);
  }

  /** The histogram of the chosen channel. @returns {import("./plot.js").Histogram} */
  get histogram() {
    return this.hello.channels[this.field]?.histogram ?? this.hello.histogram;
  }

  /** @param {number} field @param {Transfer} transfer */
  put(field, transfer) {
    if (field === 0) this.state.transfer = transfer;
    else this.state.others = this.state.others.map((other, n) => (n === field - 1 ? transfer : other));
  }

  /** Draws the view as fast as the hand moves. */
  move() {
    this.isMoving = true;
    this.request();
  }

  /** The hand rests: the picture is refined, and the state kept. */
  settle() {
    this.isMoving = false;
    this.request();
    this.history?.commit();
    this.keepAddress();
    this.shows.showHistory();
  }

  /** Rests after a while without keys. */
  restSoon() {
    clearTimeout(this.rest);
    this.rest = window.setTimeout(() => this.settle(), KEY_REST);
  }

  /** Sends what the server does not have, and asks for a picture. */
  request() {
    if (!this.history || !this.connection.isOpen) return;
    // The last step of a sequence stands until the next one is there.
    const isOther = this.sync() && !this.isPlaying;
    this.id += 1;
    const { camera, look, transfer } = this.state;
    this.connection.send({ type: "view", id: this.id, camera, ...this.picture.size(), moving: this.isMoving, playing: this.isPlaying });
    const isMoving = this.isMoving || this.isPlaying;
    this.shows.requested({ id: this.id, isOther, transfer: [transfer.colors, transfer.opacities, look.frame], background: look.background, isMoving });
  }

  /** Sends the look and the transfer functions that the server does not have. @returns whether there were some */
  sync() {
    const { look, transfer, others } = this.state;
    const transfers = [transfer, ...others].map(({ colors, opacities }) => [colors, opacities]);
    const isOther = !isEqual(this.sent.look, look);
    if (isOther) this.connection.send({ type: "look", look });
    const changed = transfers.filter(([colors, opacities], field) => {
      const isSent = isEqual(this.sent.transfers[field], [colors, opacities]);
      if (!isSent) this.connection.send({ type: "transfer", field, colors, opacities });
      return !isSent;
    });
    this.sent = { look: copy(look), transfers: copy(transfers) };
    return isOther || changed.length > 0;
  }

  /** The server refused the last change: what it shows still is shown here, too. */
  takeBack() {
    if (!this.history?.takeBack()) return;
    this.shows.show();
    this.settle();
  }

  /** @param {(look: Look) => void} change @param {boolean} isDone */
  changeLook(change, isDone) {
    if (!this.history) return;
    const own = copy(this.state.look);
    change(own);
    this.state.look = own;
    this.shows.show();
    if (isDone) this.settle();
    else this.move();
  }

  /** Shows another step of a sequence. The rest of the page stays as it is. @param {number} frame @param {boolean} isDone */
  changeStep(frame, isDone) {
    if (!this.history) return;
    this.state.look = { ...this.state.look, frame };
    this.shows.showTime();
    if (isDone) this.settle();
    else if (this.isPlaying) this.request();
    else this.move();
    this.stepId = this.id;
  }

  /** Slices change without a new picture. @param {import("./state.js").SlicesState} own @param {boolean} isDone */
  keepSlices(own, isDone) {
    this.state.slices = own;
    if (!isDone) return;
    this.history?.commit();
    this.keepAddress();
    this.shows.showHistory();
  }

  /** @param {(camera: Camera) => Camera} change */
  changeCamera(change) {
    if (!this.history) return;
    this.state.camera = change(this.state.camera);
    this.shows.showCamera();
    this.move();
  }

  /** Looks from a side. @param {{ azimuth: number, elevation: number }} side */
  look({ azimuth, elevation }) {
    const { isFitted } = this;
    this.changeCamera((camera) => ({ ...camera, azimuth, elevation, roll: 0 }));
    if (isFitted) this.fit();
    else this.settle();
  }

  /** Whether the user has neither zoomed nor moved since the last fit. */
  get isFitted() {
    return this.history !== null && isEqual(this.fittedTo, [this.state.camera.center, this.state.camera.projection]);
  }

  /** The picture has another size. */
  resized() {
    this.picture.paint();
    if (!this.history || this.awaits !== "nothing") return;
    if (!this.isFitted) return this.settle();
    // Until the camera is there, the picture has the new size.
    this.move();
    this.fit("resized");
  }

  /** No camera comes: the view stays. */
  fitFailed() {
    if (this.awaits === "nothing") return;
    this.awaits = "nothing";
    this.settle();
  }

  /** Asks what takes the server a while. @param {object} question @param {string} what is done meanwhile */
  ask(question, what) {
    this.shows.asked(what);
    this.connection.send(question);
  }

  /** @param {"fit" | "first" | "resized"} [why] */
  fit(why = "fit") {
    this.awaits = why;
    this.ask({ type: "fit", camera: this.state.camera, ...this.picture.size() }, "fitting the view");
  }

  /** @param {Camera} camera */
  fitted(camera) {
    this.state.camera = camera;
    this.fittedTo = copy([camera.center, camera.projection]);
    // Undo does not return to the size before.
    if (this.awaits === "resized" && this.history) this.history.past[this.history.at].camera = copy(camera);
    if (this.awaits === "first" && this.history) {
      // The first view of this page: undo ends here.
      this.history.past = [copy(this.state)];
      this.history.at = 0;
      this.hello.camera = copy(camera);
    }
    this.awaits = "nothing";
    this.shows.showCamera();
    this.settle();
  }

  reset() {
    this.replace(copy(this.initial));
  }

  /** @param {number} steps −1: undo, 1: redo */
  go(steps) {
    if (!this.history?.go(steps)) return;
    this.shows.show();
    this.settle();
  }

  /** @param {State | null} state */
  replace(state) {
    if (!this.history || !state) return;
    this.history.now = state;
    this.shows.show();
    this.settle();
  }

  /** The program shows something else. @param {{ camera: Camera, look: Look, transfer: Transfer, others: Transfer[] }} given */
  give({ camera, look, transfer, others }) {
    if (this.history) this.replace({ ...this.state, camera, look, transfer, others });
  }

  /** A channel gets another transfer function and another look at once. @param {number} field @param {Transfer} transfer
   * @param {(look: Look) => void} change @param {boolean} isDone */
  changeField(field, transfer, change, isDone) {
    this.put(field, transfer);
    this.changeLook(change, isDone);
  }

  /** Takes a transfer function that was chosen as a whole, by default for the chosen channel. @param {Transfer} transfer @param {number} [field] */
  setTransfer(transfer, field = this.field) {
    this.put(field, transfer);
    this.shows.show();
    this.settle();
  }

  keepAddress() {
    clearTimeout(this.addressTimer);
    this.addressTimer = window.setTimeout(() => {
      if (!this.history) return;
      const fragment = toFragment(this.state, this.initial);
      window.history.replaceState(null, "", fragment === null ? location.pathname : `#${fragment}`);
    }, ADDRESS_TIME);
  }

  listen() {
    new ResizeObserver(() => this.resized()).observe(this.picture.canvas);
    addEventListener("hashchange", () => {
      if (this.history) this.replace(this.fromAddress());
    });
  }
}
