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
    /** The picture that is shown. @type {ImageBitmap | null} */
    this.bitmap = null;
  }

  /** Size of the picture to ask for, in device pixels. */
  size() {
    const { clientWidth, clientHeight } = this.canvas;
    const [w, h] = [Math.max(clientWidth, 1), Math.max(clientHeight, 1)];
    const ratio = Math.min(devicePixelRatio || 1, Math.sqrt(MOST_PIXELS / (w * h)));
    return { width: Math.max(1, Math.round(w * ratio)), height: Math.max(1, Math.round(h * ratio)) };
  }

  /** Draws a picture; false if a later one is shown already. @param {import("./connection.js").Received} picture */
  async draw({ blob }) {
    this.arrived += 1;
    const number = this.arrived;
    const bitmap = await createImageBitmap(blob);
    const isNewest = number > this.shown;
    if (!isNewest) {
      bitmap.close();
      return false;
    }
    this.shown = number;
    this.bitmap?.close();
    this.bitmap = bitmap;
    this.paint();
    return true;
  }

  /** Draws the picture that is shown, as high as the window. Its shape stays where the window has another one: the next picture is as wide. */
  paint() {
    const { canvas, context, bitmap } = this;
    const { width, height } = this.size();
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    context.clearRect(0, 0, width, height);
    if (!bitmap) return;
    const wide = (bitmap.width / bitmap.height) * height;
    // Small pictures are a pixel off.
    const across = Math.abs(wide - width) * bitmap.height < 2 * height ? width : wide;
    context.imageSmoothingQuality = "high";
    context.drawImage(bitmap, (width - across) / 2, 0, across, height);
  }

  /** A place of the window in half heights from the middle, upwards. @param {{ clientX: number, clientY: number }} event */
  place({ clientX, clientY }) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return { x: (clientX - left - width / 2) / (height / 2), y: (top + height / 2 - clientY) / (height / 2) };
  }
}
