import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { createServer } from 'node:http';
import type { AddressInfo } from 'node:net';
import { afterEach, beforeEach, describe, expect, it } from 'vitest';
import { WebSocket as NodeWebSocket, WebSocketServer } from 'ws';
import { ApiError, call } from '../src/api';
import { SheetService } from '../src/gen/kerf/v1/sheets_pb';
import { Encoding, Ended_Reason, WatchRequestSchema, WatchResponseSchema } from '../src/gen/kerf/v1/stream_pb';
import type { WatchRequest } from '../src/gen/kerf/v1/stream_pb';
import { FrameClock } from '../src/stream/frame_clock';
import { Watch } from '../src/stream/watch';
import type { AudienceNews } from '../src/stream/watch';
import type { ConnectionState } from '../src/stream/connection';

// Node 18 and 20 have no WebSocket of their own.
Object.assign(globalThis, { WebSocket: NodeWebSocket });

/** Values that are waited for in the order in which they come. */
class Inbox<T> {
  private values: T[] = [];
  private waiting: ((value: T) => void) | undefined;

  put(value: T): void {
    if (this.waiting) this.waiting(value);
    else this.values.push(value);
    this.waiting = undefined;
  }

  next(): Promise<T> {
    if (this.values.length > 0) return Promise.resolve(this.values.shift()!);
    return new Promise((resolve) => (this.waiting = resolve));
  }

  async until(accept: (value: T) => boolean): Promise<T> {
    for (;;) {
      const value = await this.next();
      if (accept(value)) return value;
    }
  }
}

type ResponseKind = MessageInitShape<typeof WatchResponseSchema>['kind'];

/** The server's end of the stream, driven by the test. */
class FakeServer {
  readonly requests = new Inbox<WatchRequest['kind']>();
  private readonly server = new WebSocketServer({ port: 0, host: '127.0.0.1', handleProtocols: () => 'kerf.v1' });
  private socket: NodeWebSocket | undefined;

  constructor() {
    this.server.on('connection', (socket) => {
      this.socket = socket;
      socket.on('message', (bytes: Buffer) => this.requests.put(fromBinary(WatchRequestSchema, bytes).kind));
    });
  }

  async url(): Promise<string> {
    if (!this.server.address()) await new Promise((resolve) => this.server.once('listening', resolve));
    return `ws://127.0.0.1:${(this.server.address() as AddressInfo).port}/watch`;
  }

  send(kind: ResponseKind): void {
    this.socket!.send(toBinary(WatchResponseSchema, create(WatchResponseSchema, { kind })));
  }

  /** A triangle, self-contained. */
  sendKeyframe(sequence: bigint, tick: bigint, { withTopology = sequence === 1n } = {}): void {
    this.send({
      case: 'frame',
      value: {
        sequence,
        tick,
        baseTick: -1n,
        topologyVersion: 1,
        epoch: sequence === 1n ? 'one' : '',
        numVertices: 3,
        encoding: Encoding.RAW,
        positions: new Uint8Array(18),
        box: { min: {}, max: {} },
        topology:
          !withTopology
            ? undefined
            : {
                baseVersion: -1,
                numSlots: 1,
                numListedSlots: 1,
                numListedVertices: 3,
                triangles: new Uint8Array(Int32Array.of(0, 1, 2).buffer),
                pieces: new Uint8Array(4),
                materialPositions: new Uint8Array(24),
                numPieces: 1,
              },
      },
    });
  }

  drop(): void {
    this.socket!.terminate();
  }

  close(): void {
    this.server.clients.forEach((client) => client.terminate());
    this.server.close();
  }
}

describe('Watch', () => {
  let server: FakeServer;
  let watch: Watch;
  let states: Inbox<{ state: ConnectionState; detail: string }>;
  let ticks: Inbox<number>;
  let rejections: Inbox<string>;
  let news: Inbox<AudienceNews>;

  beforeEach(async () => {
    [states, ticks, rejections, news] = [new Inbox(), new Inbox(), new Inbox(), new Inbox()];
    server = new FakeServer();
    watch = new Watch(await server.url(), 'sheets/demo', {
      onState: (state, detail) => states.put({ state, detail }),
      onFrame: (mirror) => ticks.put(mirror.tick),
      onRejection: ({ message }) => rejections.put(message),
      onNews: (message) => news.put(message),
    });
    expect(await server.requests.next()).toMatchObject({
      case: 'start',
      value: { name: 'sheets/demo', window: 0, epoch: '', audience: true },
    });
  });

  afterEach(() => {
    watch.close();
    server.close();
  });

  it('applies frames as they come and acknowledges the newest, once, when told to', async () => {
    server.sendKeyframe(1n, 5n);
    server.sendKeyframe(2n, 8n);
    expect(await ticks.next()).toBe(5);
    expect(await ticks.next()).toBe(8);
    watch.acknowledge();
    watch.acknowledge();
    watch.send({ case: 'release', value: { grabId: 'last' } });
    const ack = await server.requests.next();
    expect(ack).toMatchObject({ case: 'ack', value: { sequence: 2n } });
    expect((ack as { value: { heldUs: bigint } }).value.heldUs).toBeGreaterThan(0n);
    expect(await server.requests.next()).toMatchObject({ case: 'release' });
  });

  it('reconnects by itself after a loss and goes on from a keyframe, keeping the last picture meanwhile', async () => {
    server.sendKeyframe(1n, 5n);
    await ticks.next();
    server.drop();
    await states.until(({ state, detail }) => state === 'lost' && detail.includes('trying again'));
    expect(watch.mirror?.tick).toBe(5);
    expect(watch.send({ case: 'release', value: { grabId: 'x' } })).toBe(false);
    expect(await server.requests.next()).toMatchObject({ case: 'start', value: { epoch: 'one', topologyVersion: 1 } });
    server.sendKeyframe(1n, 40n);
    expect(await ticks.next()).toBe(40);
    expect(watch.state).toBe('live');
  });

  it('goes on from the triangles that it has where the server knows them', async () => {
    server.sendKeyframe(1n, 5n);
    await ticks.next();
    server.drop();
    expect(await server.requests.next()).toMatchObject({ case: 'start', value: { epoch: 'one', topologyVersion: 1 } });
    server.sendKeyframe(1n, 7n, { withTopology: false });
    expect(await ticks.next()).toBe(7);
    expect(watch.mirror?.numSlots).toBe(1);
    expect([...watch.mirror!.triangles.subarray(0, 3)]).toEqual([0, 1, 2]);
  });

  it('asks for no frames while nobody looks, and again on the next connection', async () => {
    watch.setPace({ isPaused: true, maxRateHz: 0 });
    server.sendKeyframe(1n, 5n);
    await ticks.next();
    expect(await server.requests.next()).toMatchObject({ case: 'pace', value: { paused: true } });
    watch.setPace({ isPaused: true, maxRateHz: 0 });
    watch.setPace({ isPaused: false, maxRateHz: 0 });
    expect(await server.requests.next()).toMatchObject({ case: 'pace', value: { paused: false } });
    watch.setPace({ isPaused: false, maxRateHz: 5 });
    expect(await server.requests.next()).toMatchObject({ case: 'pace', value: { paused: false, maxRateHz: 5 } });
  });

  it('starts anew when a frame does not fit', async () => {
    server.sendKeyframe(1n, 5n);
    await ticks.next();
    server.sendKeyframe(3n, 9n);
    const lost = await states.until(({ state }) => state === 'lost');
    expect(lost.detail).toContain('frame 3 after frame 1');
    expect(await server.requests.next()).toMatchObject({ case: 'start', value: { epoch: '' } });
  });

  it('hands on news of the audience as they come, and acknowledges frames only', async () => {
    server.send({ case: 'audience', value: { viewers: [{ number: 4, tokenId: 'alice' }], numViewers: 1, ownNumber: 4 } });
    server.send({ case: 'activity', value: { tokenId: 'bob', byLink: true, call: 'CreateCut', unixUs: 7n } });
    const audience = await news.next();
    expect(audience).toMatchObject({ case: 'audience', value: { ownNumber: 4, viewers: [{ number: 4, tokenId: 'alice' }] } });
    expect(await news.next()).toMatchObject({ case: 'activity', value: { tokenId: 'bob', byLink: true, call: 'CreateCut' } });
    expect(watch.state).toBe('connecting');
    watch.acknowledge();
    server.sendKeyframe(1n, 5n);
    await ticks.next();
    server.send({ case: 'pointer', value: { viewer: 9, material: { x: 0.25, y: 0.5 } } });
    expect(await news.next()).toMatchObject({ case: 'pointer', value: { viewer: 9, material: { x: 0.25, y: 0.5 } } });
    watch.acknowledge();
    watch.send({ case: 'pointer', value: { material: { x: 1, y: 2 } } });
    expect(await server.requests.next()).toMatchObject({ case: 'ack', value: { sequence: 1n } });
    const { case: kind, value } = (await server.requests.next()) as { case: string; value: { material: object } };
    expect([kind, value.material]).toMatchObject(['pointer', { x: 1, y: 2 }]);
  });

  it('tells a rejection, and stays ended when the sheet is deleted', async () => {
    server.send({ case: 'rejection', value: { grabId: 'g', message: 'no vertex 99' } });
    expect(await rejections.next()).toBe('no vertex 99');
    server.send({ case: 'ended', value: { reason: Ended_Reason.SHEET_DELETED, message: 'deleted by its owner' } });
    const ended = await states.until(({ state }) => state === 'ended');
    expect(ended.detail).toBe('deleted by its owner');
    watch.retryNow();
    expect(watch.state).toBe('ended');
  });
});

describe('call', () => {
  async function answer(
    status: number,
    body: string,
  ): Promise<{ baseUrl: string; seen: () => string; close: () => void }> {
    let seen = '';
    const server = createServer((request, response) => {
      let text = '';
      request.on('data', (chunk) => (text += chunk));
      request.on('end', () => {
        seen = `${request.method} ${request.url} ${text}`;
        response.writeHead(status).end(body);
      });
    });
    await new Promise<void>((resolve) => server.listen(0, '127.0.0.1', resolve));
    const baseUrl = `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
    return { baseUrl, seen: () => seen, close: () => server.close() };
  }

  it('posts protobuf JSON to the method and reads the reply, unknown fields included', async () => {
    const server = await answer(200, '{"name":"sheets/demo","tick":"12","runState":"PAUSED","notYetKnown":1}');
    const sheet = await call(SheetService.method.stepSheet, { name: 'sheets/demo', ticks: 3 }, server);
    server.close();
    expect(server.seen()).toBe('POST /kerf.v1.SheetService/StepSheet {"name":"sheets/demo","ticks":3}');
    expect(sheet.tick).toBe(12n);
  });

  it('turns a refusal into its code and message, whatever form it has', async () => {
    const cases: [number, string, string, string][] = [
      [404, '{"code":5,"message":"no sheet \\"nope\\""}', 'NOT_FOUND', 'no sheet "nope"'],
      [400, '{"code":"INVALID_ARGUMENT","message":"ticks"}', 'INVALID_ARGUMENT', 'ticks'],
      [502, '<h1>Bad gateway</h1>', 'UNKNOWN', '<h1>Bad gateway</h1>'],
    ];
    for (const [status, body, code, message] of cases) {
      const server = await answer(status, body);
      const refusal = await call(SheetService.method.getSheet, { name: 'sheets/nope' }, server).catch((error) => error);
      server.close();
      expect(refusal).toBeInstanceOf(ApiError);
      expect({ code: refusal.code, message: refusal.message }).toEqual({ code, message });
    }
  });

  it('says UNAVAILABLE when nobody answers', async () => {
    const server = await answer(200, '{}');
    server.close();
    const refusal = await call(SheetService.method.listSheets, {}, server).catch((error) => error);
    expect(refusal).toMatchObject({ code: 'UNAVAILABLE' });
  });
});

describe('FrameClock', () => {
  it('measures against the fastest frame, whatever the offset of the clocks', () => {
    const clock = new FrameClock();
    expect(clock.ageMs(0)).toBeUndefined();
    clock.arrived(1_000_000n, 51_020);
    expect(clock.ageMs(51_025)).toBeCloseTo(5);
    clock.arrived(1_016_000n, 51_021);
    expect(clock.ageMs(51_021)).toBeCloseTo(0);
    clock.arrived(1_032_000n, 51_060);
    expect(clock.ageMs(51_061)).toBeCloseTo(24);
  });
});
