// What is drawn over the picture: handles of the crop box and of clip planes, measured distances, the pivot.

/** @typedef {import("./gestures.js").Place} Place */

export class Overlay {
  /** @param {import("./picture.js").Picture} picture @param {(draw: Overlay) => void} paint draws everything */
  constructor(picture, paint) {
    this.picture = picture;
    this.paint = paint;
    this.canvas = /** @type {HTMLCanvasElement} */ (document.getElementById("overlay"));
    this.context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
    this.waits = false;
  }

  /** Draws with the next frame of the browser. */
  draw() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      const ratio = devicePixelRatio || 1;
      const { clientWidth, clientHeight } = this.picture.canvas;
      [this.canvas.width, this.canvas.height] = [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)];
      this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
      this.paint(this);
    });
  }

  /** @param {Place} place @returns {[number, number]} pixels */
  toPixels({ x, y }) {
    const { clientWidth, clientHeight } = this.picture.canvas;
    return [clientWidth / 2 + (x * clientHeight) / 2, clientHeight / 2 - (y * clientHeight) / 2];
  }

  /** Half heights per pixel. */
  get pixel() {
    return 2 / Math.max(this.picture.canvas.clientHeight, 1);
  }

  /** A line that is seen on any picture. @param {Place[]} places @param {string} color @param {boolean} [isClosed] */
  line(places, color, isClosed = false) {
    const { context } = this;
    context.beginPath();
    places.forEach((place, n) => (n === 0 ? context.moveTo(...this.toPixels(place)) : context.lineTo(...this.toPixels(place))));
    if (isClosed) context.closePath();
    for (const [width, style] of /** @type {const} */ ([[3.5, "rgba(0, 0, 0, 0.55)"], [1.5, color]])) {
      context.lineWidth = width;
      context.strokeStyle = style;
      context.stroke();
    }
  }

  /** @param {Place} place @param {string} color @param {number} radius */
  dot(place, color, radius) {
    const { context } = this;
    context.beginPath();
    context.arc(...this.toPixels(place), radius, 0, 2 * Math.PI);
    context.fillStyle = color;
    context.fill();
    context.lineWidth = 1.5;
    context.strokeStyle = "rgba(0, 0, 0, 0.7)";
    context.stroke();
  }

  /** @param {Place} place @param {string} text */
  label(place, text) {
    const { context } = this;
    const [x, y] = this.toPixels(place);
    context.font = "600 13px system-ui, sans-serif";
    context.textAlign = "center";
    context.lineWidth = 4;
    context.lineJoin = "round";
    context.strokeStyle = "rgba(0, 0, 0, 0.75)";
    context.strokeText(text, x, y);
    context.fillStyle = "#ffffff";
    context.fillText(text, x, y);
  }
}
