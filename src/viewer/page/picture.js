// The picture: drawn as it arrives, as large as the window.

/** Most pixels that are asked for: more would be slow and hardly seen. */
const MOST_PIXELS = 4_000_000;

export class Picture {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    /** Numbers of the pictures, in the order of arrival: decoding may change it. */
    this.arrived = 0;
    this.shown = 0;
  }

  /** Size of the picture to ask for, in device pixels. */
  size() {
    const { clientWidth, clientHeight } = this.canvas;
    const [w, h] = [Math.max(clientWidth, 1), Math.max(clientHeight, 1)];
    const ratio = Math.min(devicePixelRatio || 1, Math.sqrt(MOST_PIXELS / (w * h)));
    return { width: Math.max(1, Math.round(w * ratio)), height: Math.max(1, Math.round(h * ratio)) };
  }

  /** Draws a picture, scaled to the window; false if a later one is shown already. @param {import("./connection.js").Received} picture */
  async draw({ blob }) {
    this.arrived += 1;
    const number = this.arrived;
    const bitmap = await createImageBitmap(blob);
    const isNewest = number > this.shown;
    if (isNewest) {
      this.shown = number;
      const { width, height } = this.size();
      if (this.canvas.width !== width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [width, height];
      this.context.clearRect(0, 0, width, height);
      this.context.imageSmoothingQuality = "high";
      this.context.drawImage(bitmap, 0, 0, width, height);
    }
    bitmap.close();
    return isNewest;
  }

  /** A place of the window in half heights from the middle, upwards. @param {{ clientX: number, clientY: number }} event */
  place({ clientX, clientY }) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return { x: (clientX - left - width / 2) / (height / 2), y: (top + height / 2 - clientY) / (height / 2) };
  }
}
