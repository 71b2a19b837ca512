import { createServer, connect } from 'node:net';

// A timer may fire this much early.
const kTimerMs = 1;

/** Bytes on their way in one direction: each piece leaves `delayMs` after it came, and not faster than `bytesPerS`. */
class Pipe {
  queue = [];
  timer = undefined;
  freeAtMs = 0;

  constructor(to, limits, passed) {
    Object.assign(this, { to, limits, passed });
  }

  push(bytes) {
    const now = performance.now();
    const { delayMs, bytesPerS } = this.limits;
    this.freeAtMs = Math.max(now, this.freeAtMs) + (1000 * bytes.length) / bytesPerS;
    this.queue.push({ bytes, atMs: this.freeAtMs + delayMs });
    this.schedule();
  }

  schedule() {
    if (this.timer !== undefined || this.queue.length === 0) return;
    const waitMs = Math.max(0, this.queue[0].atMs - performance.now());
    this.timer = setTimeout(() => {
      this.timer = undefined;
      while (this.queue.length > 0 && this.queue[0].atMs <= performance.now() + kTimerMs) {
        const { bytes } = this.queue.shift();
        this.to.write(bytes);
        this.passed?.(bytes);
      }
      this.schedule();
    }, waitMs);
  }
}

/** The WebSocket messages in a stream of bytes that arrives in any pieces, after the head of its HTTP upgrade. */
class MessageReader {
  pending = Buffer.alloc(0);
  isUpgraded = false;

  /** Calls `message` with the first bytes of each binary message. */
  read(bytes, message) {
    this.pending = Buffer.concat([this.pending, bytes]);
    if (!this.isUpgraded) {
      const end = this.pending.indexOf('\r\n\r\n');
      if (end < 0) return;
      this.pending = this.pending.subarray(end + 4);
      this.isUpgraded = true;
    }
    for (;;) {
      const size = this.take(message);
      if (size === 0) return;
      this.pending = this.pending.subarray(size);
    }
  }

  // Bytes of the first message, head included; 0 while it is not whole.
  take(message) {
    const { pending } = this;
    if (pending.length < 2) return 0;
    const isMasked = (pending[1] & 0x80) !== 0;
    let length = pending[1] & 0x7f;
    let at = 2;
    if (length === 126) [length, at] = [pending.length < 4 ? 0 : pending.readUInt16BE(2), 4];
    else if (length === 127) [length, at] = [pending.length < 10 ? 0 : Number(pending.readBigUInt64BE(2)), 10];
    const begin = at + (isMasked ? 4 : 0);
    if (pending.length < begin || pending.length < begin + length) return 0;
    const payload = Buffer.from(pending.subarray(begin, begin + length));
    if (isMasked) for (let i = 0; i < length; ++i) payload[i] ^= pending[at + (i % 4)];
    if ((pending[0] & 0x0f) === 2) message(payload);
    return begin + length;
  }
}

function varint(bytes, at) {
  let value = 0;
  for (let shift = 1; at < bytes.length; ++at, shift *= 128) {
    value += (bytes[at] & 0x7f) * shift;
    if (bytes[at] < 128) return value;
  }
  throw new Error('a number that does not end');
}

/** Traffic on one WebSocket of frames or pictures. */
export class StreamCount {
  sent = 0;
  acknowledged = 0;
  mostInFlight = 0;

  get inFlight() {
    return this.sent - this.acknowledged;
  }

  // Frame and image messages: field 1 of WatchResponse and WatchImagesResponse, length-delimited.
  fromServer(payload) {
    if (payload[0] !== 0x0a) return;
    this.sent += 1;
    this.mostInFlight = Math.max(this.mostInFlight, this.inFlight);
  }

  // Acknowledgements: field 2 of WatchRequest and WatchImagesRequest, whose field 1 is the sequence.
  fromClient(payload) {
    if (payload[0] === 0x12 && payload[2] === 0x08) this.acknowledged = varint(payload, 3);
  }
}

/**
 * A TCP proxy in front of `url` that delays and throttles. Counts what is in flight between its two ends, in the order
 * in which the server sends it and the server's acknowledgements reach it.
 * @param limits  delayMs: each way; bytesPerS: each way and connection; others may be set at any time
 */
export async function startSlowProxy(url, limits) {
  const { hostname, port } = new URL(url);
  const sockets = new Set();
  const counts = new Map();
  const server = createServer((client) => {
    const upstream = connect(Number(port), hostname);
    let count;
    const [fromClient, fromServer] = [new MessageReader(), new MessageReader()];
    const toServer = new Pipe(upstream, limits, (bytes) => {
      if (count) fromClient.read(bytes, (payload) => count.fromClient(payload));
    });
    const toClient = new Pipe(client, limits);
    client.on('data', (bytes) => {
      const path = count ? undefined : /^GET (\/watch|\/images) /.exec(bytes.toString('latin1'))?.[1];
      if (path) {
        count = new StreamCount();
        counts.set(path, count);
      }
      toServer.push(bytes);
    });
    upstream.on('data', (bytes) => {
      if (count) fromServer.read(bytes, (payload) => count.fromServer(payload));
      toClient.push(bytes);
    });
    for (const [one, other] of [
      [client, upstream],
      [upstream, client],
    ]) {
      sockets.add(one);
      one.setNoDelay(true);
      one.on('error', () => one.destroy());
      one.on('close', () => {
        sockets.delete(one);
        other.destroy();
      });
    }
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    /** StreamCount of the newest connection to this path; undefined before the first. */
    count: (path) => counts.get(path),
    stop: () => {
      sockets.forEach((socket) => socket.destroy());
      return new Promise((resolve) => server.close(resolve));
    },
  };
}
