// The status line, and sentences about problems. It says only of a picture of the present request what that picture is.

/** Milliseconds that a problem is shown for. */
const PROBLEM_TIME = 8000;
/** Milliseconds without a picture while a hand moves, after which the last one counts as old. */
const LATE = 600;
/** Milliseconds after which it is said what the server is asked. */
const ASKED = 150;
/** What the server does before a picture. @type {Record<string, string>} */
const WORK = { check: "checking the device", programs: "building programs" };

/** @typedef {import("./connection.js").Received} Received */
/** @typedef {{ what: string, done: number, of: number }} Work */

export class Status {
  constructor() {
    const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
    this.line = element("status");
    this.problemLine = element("problem");
    this.stage = element("stage");
    this.isReady = false;
    /** @type {Received | null} */
    this.last = null;
    /** The last view of which no better picture comes. */
    this.refinedId = -1;
    /** Numbers of the newest view, and of the first one with the present volume, look and curves. */
    this.requested = { id: 0, since: 0 };
    /** Whether no picture of the volume was drawn yet. */
    this.isFirst = true;
    /** The last view that could not be drawn. */
    this.failedId = -1;
    /** What is about to replace the volume, as a text. */
    this.coming = "";
    /** What the server does. @type {Work | null} */
    this.work = null;
    this.isMoving = false;
    /** What was shown last; tests read it. */
    this.shown = { id: -1, step: "", pictures: 0 };
    /** When the last pictures came. @type {number[]} */
    this.times = [];
    this.timer = 0;
    this.late = 0;
    /** What the server is asked, if the answer takes a while. */
    this.asked = "";
    this.asking = 0;
  }

  /** Another volume is there: no picture shows it yet. @param {number} id of the last view */
  begin(id) {
    this.requested = { id: id + 1, since: id + 1 };
    this.isFirst = true;
    this.work = null;
    this.ask("");
    this.come("");
  }

  /** A view was requested. @param {number} id @param {boolean} isOther whether its look or a curve is another one @param {boolean} isMoving */
  request(id, isOther, isMoving) {
    this.requested = { id, since: isOther ? id : this.requested.since };
    this.isMoving = isMoving;
    this.say();
    clearTimeout(this.late);
    if (isMoving) this.late = window.setTimeout(() => this.say(), LATE);
  }

  /** @param {string} coming what replaces the volume, or nothing */
  come(coming) {
    this.coming = coming;
    this.say();
  }

  /** The server is asked about the volume, and the present picture is not the last. @param {string} what it does, or nothing */
  ask(what) {
    clearTimeout(this.asking);
    this.asked = "";
    if (what) this.asking = window.setTimeout(() => { this.asked = what; this.say(); }, ASKED);
    else this.say();
  }

  /** @param {Work | null} work */
  working(work) {
    this.work = work;
    this.say();
  }

  /** A picture was drawn. @param {Received} received */
  draw(received) {
    const step = received.id === this.refinedId ? "refined" : received.step;
    Object.assign(this.shown, { id: received.id, step, pictures: this.shown.pictures + 1 });
    this.times = [...this.times.slice(-29), performance.now()];
    this.last = received;
    this.work = null;
    this.isFirst &&= received.id < this.requested.since;
    this.say();
  }

  /** A view could not be drawn. @param {number} id */
  failed(id) {
    this.failedId = id;
    this.work = null;
    this.say();
  }

  /** No better picture of a view comes. @param {number} id */
  refined(id) {
    this.refinedId = id;
    if (id === this.shown.id) this.shown.step = "refined";
    this.say();
  }

  /** @param {boolean} isReady whether programs are built */
  ready(isReady) {
    this.isReady = isReady;
    this.say();
  }

  say() {
    // Pictures that follow a hand are always a little behind it.
    const isFollowing = this.isMoving && !this.isFirst && performance.now() - (this.times.at(-1) ?? 0) < LATE;
    const isOld = this.shown.id < this.requested.since && !isFollowing;
    this.stage.classList.toggle("coming", this.coming !== "" || this.isFirst);
    this.stage.classList.toggle("old", isOld);
    this.line.textContent = this.coming || (this.asked && `${this.asked} …`) || (this.shown.id < this.requested.id ? this.awaited(isOld) : this.present());
  }

  /** What is awaited. @param {boolean} isOld */
  awaited(isOld) {
    if (this.failedId === this.requested.id) return "no picture of this view";
    if (this.work) {
      const { what, done, of } = this.work;
      return `${WORK[what]}${of > 0 ? `, ${Math.min(done + 1, of)} of ${of}` : ""} …`;
    }
    return this.isMoving && !isOld && this.last?.step === "moving" ? this.present() : "drawing …";
  }

  /** What the picture is. */
  present() {
    if (!this.last) return "";
    const { width, height, step } = this.last;
    const size = `${width} × ${height}`;
    const text = step === "moving" ? `${size}, ${this.rate()} frames/s` : `${size}, ${step === "half" ? "high" : this.shown.step}`;
    return this.isReady ? text : `${text} – preparing programs for the device …`;
  }

  rate() {
    const recent = this.times.filter((time) => time > performance.now() - 1000);
    if (recent.length < 2) return "–";
    return Math.round((1000 * (recent.length - 1)) / (recent[recent.length - 1] - recent[0]));
  }

  /** @param {string} sentence @param {"problem" | "lost" | "note"} [kind] what is lost is shown until the connection is back */
  problem(sentence, kind = "problem") {
    this.problemLine.classList.toggle("note", kind === "note");
    // As it is: many begin with the name of a file.
    this.problemLine.textContent = sentence;
    this.problemLine.hidden = false;
    clearTimeout(this.timer);
    if (kind !== "lost") this.timer = window.setTimeout(() => this.clear(), PROBLEM_TIME);
  }

  clear() {
    this.problemLine.hidden = true;
  }
}
