// Time: the step of a sequence, and playing.

/** @param {string} id */
const field = (id) => /** @type {HTMLInputElement} */ (document.getElementById(id));

export class Time {
  /** @param {import("./session.js").Session} session @param {import("./status.js").Status} status */
  constructor(session, status) {
    this.session = session;
    this.status = status;
    this.steps = 1;
    /** When the next step is due. */
    this.due = 0;
    this.timer = 0;
    field("time-play").addEventListener("click", () => this.toggle());
    field("time-step").addEventListener("input", () => this.session.changeStep(field("time-step").valueAsNumber, false));
    field("time-step").addEventListener("change", () => this.rest());
  }

  /** @param {number} steps of the volume */
  begin(steps) {
    if (steps !== this.steps) this.pause();
    this.steps = steps;
    field("time").hidden = steps < 2;
    /** @type {HTMLElement} */ (document.getElementById("stage")).classList.toggle("with-time", steps > 1);
    field("time-step").max = String(steps - 1);
  }

  show() {
    const { frame } = this.session.state.look;
    field("time-step").value = String(frame);
    field("time-shown").value = `${frame + 1} of ${this.steps}`;
  }

  toggle() {
    if (this.session.isPlaying) this.pause();
    else this.play();
  }

  play() {
    if (this.steps < 2 || !this.session.history) return;
    this.session.isPlaying = true;
    this.due = performance.now();
    this.showButton();
    this.advance();
  }

  pause() {
    if (!this.session.isPlaying) return;
    this.session.isPlaying = false;
    clearTimeout(this.timer);
    this.showButton();
    this.rest();
  }

  /** The hand or time rests: the picture of the step is refined. */
  rest() {
    if (this.session.isPlaying) return;
    this.session.settle();
    this.session.stepId = this.session.id;
  }

  /** @param {number} by −1 or 1; from the end to the start, too */
  step(by) {
    if (this.steps < 2 || !this.session.history) return;
    this.session.changeStep((this.session.state.look.frame + by + this.steps) % this.steps, false);
    if (!this.session.isPlaying) this.session.restSoon();
  }

  showButton() {
    const { isPlaying } = this.session;
    field("time-play").textContent = isPlaying ? "Pause" : "Play";
    field("time-play").setAttribute("aria-pressed", String(isPlaying));
  }

  /** A picture was drawn. */
  drawn() {
    if (this.session.isPlaying && performance.now() >= this.due) this.advance();
  }

  /** Shows the next step when it is due and the last one was shown: a slow server leaves none out. */
  advance() {
    clearTimeout(this.timer);
    if (this.status.shown.id < this.session.stepId) return;
    const now = performance.now();
    // A late step does not make the next ones come faster.
    this.due = Math.max(this.due + 1000 / this.rate, now);
    this.timer = window.setTimeout(() => this.advance(), this.due - now);
    this.step(1);
  }

  /** Steps per second. */
  get rate() {
    const typed = field("time-rate").valueAsNumber;
    return Number.isFinite(typed) ? Math.min(Math.max(typed, 0.1), 60) : 10;
  }
}
