// The WebSocket: what the server says, and connecting again when it is lost.

/** Bytes before a picture. */
const HEADER = 20;
/** Milliseconds before the next attempt, and at most. */
const FIRST_PAUSE = 250;
const LONGEST_PAUSE = 5000;

/** The status of a WebSocket whose server does not understand a message. */
const INVALID = 1007;
const RESTARTED = "Another run of layersplat answers here, and does not know this page. Open the address that it printed. What stands after # in "
  + "the address of this page can be added to it: it is the view.";

/** Whether a server answers that gives this page no access. */
async function isRefused() {
  try {
    return (await fetch("/icon.svg")).status === 403;
  } catch {
    return false;
  }
}

/** What a picture is, by the first byte. */
export const STEPS = ["moving", "standard", "high", "half", "refined", "saved", "slices", "part"];

/** @typedef {{ step: string, id: number, width: number, height: number, milliseconds: number, blob: Blob }} Received */

export class Connection {
  /** @param {{ message: (text: any) => void, picture: (picture: Received) => void, lost: (reason: string, isBad: boolean) => void }} handlers
   * `isBad`: the server does not understand what it was sent */
  constructor(handlers) {
    this.handlers = handlers;
    this.pause = FIRST_PAUSE;
    this.bytes = 0;
    this.pictures = 0;
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") {
        this.pause = FIRST_PAUSE;
        this.handlers.message(JSON.parse(data));
      } else {
        this.receive(data);
      }
    };
    let isOpen = false;
    socket.onopen = () => { isOpen = true; };
    socket.onclose = async ({ reason, code }) => {
      this.handlers.lost(reason, code === INVALID);
      if (!isOpen && (await isRefused())) this.handlers.lost(RESTARTED, false);
      setTimeout(() => this.connect(), this.pause);
      this.pause = Math.min(2 * this.pause, LONGEST_PAUSE);
    };
    this.socket = socket;
  }

  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** @param {object} request */
  send(request) {
    if (this.isOpen) this.socket?.send(JSON.stringify(request));
  }

  /** @param {ArrayBuffer} data */
  receive(data) {
    const head = new DataView(data);
    const kind = ["image/jpeg", "image/png", "image/x-exr"][head.getUint8(1)];
    this.bytes += data.byteLength;
    this.pictures += 1;
    this.handlers.picture({
      step: STEPS[head.getUint8(0)],
      id: head.getUint32(4, true),
      width: head.getUint32(8, true),
      height: head.getUint32(12, true),
      milliseconds: head.getFloat32(16, true),
      blob: new Blob([new Uint8Array(data, HEADER)], { type: kind }),
    });
  }
}
