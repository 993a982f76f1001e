// A page without a browser: the viewer's WebSocket, as raw bytes.

import net from "node:net";

/** Bytes before a picture. */
const HEADER = 20;

/** Connects to a viewer. */
export async function connect(url) {
  const { host, hostname, port, searchParams } = new URL(url);
  const answer = await fetch(`http://${host}/?token=${searchParams.get("token")}`);
  const cookie = answer.headers.get("set-cookie").split(";")[0];
  const socket = net.connect(Number(port), hostname);
  socket.setNoDelay(true);
  socket.write(`GET /socket HTTP/1.1\r\nHost: ${host}\r\nOrigin: http://${host}\r\nCookie: ${cookie}\r\nConnection: Upgrade\r\n`
    + "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  const page = new Page(socket);
  await page.upgraded();
  page.hello = JSON.parse((await page.receive()).payload);
  return page;
}

class Page {
  constructor(socket) {
    this.socket = socket;
    this.buffer = Buffer.alloc(0);
    this.waiting = null;
    socket.on("data", (data) => {
      this.buffer = Buffer.concat([this.buffer, data]);
      this.waiting?.();
    });
    // The viewer gives up pages that answer none of its pings, and this one may read nothing for minutes.
    const pongs = setInterval(() => socket.write(Buffer.from([0x8a, 0x80, 0, 0, 0, 0])), 10_000);
    socket.on("close", () => { clearInterval(pongs); this.isClosed = true; this.waiting?.(); });
  }

  more() {
    if (this.isClosed) throw new Error("the viewer closed the connection");
    return new Promise((done) => { this.waiting = done; });
  }

  async upgraded() {
    while (!this.buffer.includes("\r\n\r\n")) await this.more();
    this.buffer = this.buffer.subarray(this.buffer.indexOf("\r\n\r\n") + 4);
  }

  /** The next message: its kind, 1 for text and 2 for a picture, and its bytes. */
  async receive() {
    for (;;) {
      const { buffer } = this;
      const short = buffer[1] & 127;
      const head = short === 126 ? 4 : short === 127 ? 10 : 2;
      if (buffer.length >= head) {
        const length = head === 2 ? short : head === 4 ? buffer.readUInt16BE(2) : Number(buffer.readBigUInt64BE(2));
        if (buffer.length >= head + length) {
          this.buffer = buffer.subarray(head + length);
          return { kind: buffer[0] & 15, payload: buffer.subarray(head, head + length) };
        }
      }
      await this.more();
    }
  }

  /** The next picture: its step, id and milliseconds on the server. */
  async picture() {
    let message = await this.receive();
    while (message.kind !== 2) message = await this.receive();
    const { payload } = message;
    return {
      step: payload[0], id: payload.readUInt32LE(4), milliseconds: payload.readFloatLE(16), bytes: payload.length - HEADER,
      width: payload.readUInt32LE(8), height: payload.readUInt32LE(12),
    };
  }

  send(request) {
    const payload = Buffer.from(JSON.stringify(request));
    const head = payload.length < 126 ? [0x81, 0x80 | payload.length] : [0x81, 0xfe, payload.length >> 8, payload.length & 255];
    this.socket.write(Buffer.concat([Buffer.from([...head, 0, 0, 0, 0]), payload]));
  }

  /** Asks for the first view, turned by some degrees. */
  view(id, degrees, moving, side = 768) {
    const { camera } = this.hello;
    this.send({ type: "view", id, camera: { ...camera, azimuth: camera.azimuth + degrees }, width: side, height: side, moving });
  }

  /** Waits for the picture of a request with one of these steps, and acknowledges all. */
  async shown(id, steps = [0, 1, 2, 3, 4]) {
    for (;;) {
      const picture = await this.picture();
      if (picture.step < 5) this.send({ type: "shown" });
      if (picture.id === id && steps.includes(picture.step)) return picture;
    }
  }

  close() {
    this.socket.destroy();
  }
}
