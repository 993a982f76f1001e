// The status line and sentences about problems.

/** Milliseconds that a problem is shown for. */
const PROBLEM_TIME = 8000;

/** @typedef {import("./connection.js").Received} Received */

export class Status {
  constructor() {
    this.line = /** @type {HTMLElement} */ (document.getElementById("status"));
    this.problemLine = /** @type {HTMLElement} */ (document.getElementById("problem"));
    this.isReady = false;
    /** @type {Received | null} */
    this.last = null;
    /** The last view of which no better picture comes. */
    this.refinedId = -1;
    /** What was shown last; tests read it. */
    this.shown = { id: -1, step: "", pictures: 0 };
    /** When the last pictures came. @type {number[]} */
    this.times = [];
    this.timer = 0;
  }

  /** A picture was drawn. @param {Received} received */
  draw(received) {
    const step = received.id === this.refinedId ? "refined" : received.step;
    Object.assign(this.shown, { id: received.id, step, pictures: this.shown.pictures + 1 });
    this.times = [...this.times.slice(-29), performance.now()];
    this.last = received;
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
    if (!this.last) return;
    const { width, height, step } = this.last;
    const size = `${width} × ${height}`;
    const text = step === "moving" ? `${size}, ${this.rate()} frames/s` : `${size}, ${step === "half" ? "high" : this.shown.step}`;
    this.line.textContent = this.isReady ? text : `${text} – preparing programs for the device …`;
  }

  rate() {
    const recent = this.times.filter((time) => time > performance.now() - 1000);
    if (recent.length < 2) return "–";
    return Math.round((1000 * (recent.length - 1)) / (recent[recent.length - 1] - recent[0]));
  }

  /** @param {string} sentence @param {"problem" | "lost" | "note"} [kind] what is lost is shown until the connection is back */
  problem(sentence, kind = "problem") {
    this.problemLine.classList.toggle("note", kind === "note");
    this.problemLine.textContent = sentence.charAt(0).toUpperCase() + sentence.slice(1);
    this.problemLine.hidden = false;
    clearTimeout(this.timer);
    if (kind !== "lost") this.timer = window.setTimeout(() => this.clear(), PROBLEM_TIME);
  }

  clear() {
    this.problemLine.hidden = true;
  }
}
