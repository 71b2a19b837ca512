// The page's and the worker's side of a stream, with a channel between them as between a page and its worker.
import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { AddressInfo } from 'node:net';
import { MessageChannel } from 'node:worker_threads';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { WebSocket as NodeWebSocket, WebSocketServer } from 'ws';
import { Encoding, FrameSchema, WatchRequestSchema, WatchResponseSchema } from '../src/gen/kerf/v1/stream_pb';
import type { Frame, WatchRequest } from '../src/gen/kerf/v1/stream_pb';
import { RemoteWatch } from '../src/stream/remote_watch';
import type { FromWorker, Port, ToWorker } from '../src/stream/watch_messages';
import { WatchService } from '../src/stream/watch_service';

Object.assign(globalThis, { WebSocket: NodeWebSocket });

// Raw frames of one triangle at x = tick.
function frame(sequence: number, tick: number, more: Omit<Partial<Frame>, '$typeName' | '$unknown'> = {}): Frame {
  return create(FrameSchema, {
    sequence: BigInt(sequence),
    tick: BigInt(tick),
    baseTick: -1n,
    topologyVersion: 1,
    numVertices: 3,
    encoding: Encoding.RAW,
    positions: new Uint8Array(new Uint16Array(9).fill(tick).buffer),
    box: { min: {}, max: { x: 65535, y: 65535, z: 65535 } },
    epoch: sequence === 1 ? 'one' : '',
    topology:
      sequence === 1
        ? {
            baseVersion: -1,
            numSlots: 1,
            numListedSlots: 1,
            numListedVertices: 3,
            triangles: new Uint8Array(Int32Array.of(0, 1, 2).buffer),
            pieces: new Uint8Array(4),
            materialPositions: new Uint8Array(24),
            numPieces: 1,
          }
        : undefined,
    ...more,
  });
}

describe('RemoteWatch', () => {
  let server: WebSocketServer;
  let channel: MessageChannel;
  const requests: WatchRequest['kind'][] = [];
  let socket: NodeWebSocket | undefined;
  let watch: RemoteWatch | undefined;
  const onState = vi.fn();
  const onRejection = vi.fn();
  const ticks: number[] = [];

  const send = (value: Frame) =>
    socket!.send(toBinary(WatchResponseSchema, create(WatchResponseSchema, { kind: { case: 'frame', value } })));
  const open = (strains = false, goesOn = false, isPaused = false) => {
    const url = `ws://127.0.0.1:${(server.address() as AddressInfo).port}/watch`;
    const events = { onState, onRejection, onFrame: ({ tick }: { tick: number }) => ticks.push(tick) };
    const port = channel.port1 as unknown as Port<ToWorker, FromWorker>;
    watch = new RemoteWatch(port, url, 'sheets/a', events, { strains, goesOn, isPaused });
    return watch;
  };
  const requested = (kind: string) => vi.waitUntil(() => requests.find((request) => request.case === kind));

  beforeEach(async () => {
    requests.length = ticks.length = 0;
    onState.mockClear();
    server = new WebSocketServer({ port: 0, host: '127.0.0.1', handleProtocols: () => 'kerf.v1' });
    server.on('connection', (connection) => {
      socket = connection;
      connection.on('message', (bytes: Buffer) => requests.push(fromBinary(WatchRequestSchema, bytes).kind));
    });
    await new Promise((resolve) => server.once('listening', resolve));
    channel = new MessageChannel();
    new WatchService(channel.port2 as unknown as Port<FromWorker, ToWorker>);
  });

  afterEach(async () => {
    watch?.close();
    server.clients.forEach((client) => client.terminate());
    server.close();
    // After the worker's side has read that the stream is closed.
    await new Promise((resolve) => setTimeout(resolve));
    channel.port1.close();
  });

  it('has what the worker decoded, and acknowledges once what was used', async () => {
    const watch = open();
    await requested('start');
    send(frame(1, 5));
    send(frame(2, 6));
    await vi.waitUntil(() => ticks.length === 2);
    expect(watch.state).toBe('live');
    const copy = watch.copy!;
    expect([copy.tick, copy.numVertices, copy.numSlots, copy.numPieces]).toEqual([6, 3, 1, 1]);
    expect([...copy.triangles]).toEqual([0, 1, 2]);
    expect(copy.positions[0]).toBe(6);
    watch.acknowledge();
    watch.acknowledge();
    expect(await requested('ack')).toMatchObject({ value: { sequence: 2n } });
    watch.send({ case: 'release', value: { grabId: 'g' } });
    await requested('release');
    expect(requests.filter((request) => request.case === 'ack')).toHaveLength(1);
  });

  it('goes on from the triangles of the stream before, and passes over what that still says', async () => {
    const first = open();
    await requested('start');
    send(frame(1, 5));
    await vi.waitUntil(() => ticks.length === 1);
    requests.length = 0;
    const second = open(true, true);
    expect(await requested('start')).toMatchObject({ value: { epoch: 'one', topologyVersion: 1, strains: true } });
    const strains = { strains: new Uint8Array(Int8Array.of(127, 0, -127).buffer), strainScale: 0.5 };
    send(frame(1, 9, { topology: undefined, ...strains }));
    await vi.waitUntil(() => ticks.length === 2);
    expect([...second.copy!.strains!]).toEqual([0.5, 0, -0.5]);
    expect([...second.copy!.triangles]).toEqual([0, 1, 2]);
    expect(first.copy!.tick).toBe(5);
  });

  it('pauses a stream that begins unseen', async () => {
    const watch = open(false, false, true);
    await requested('start');
    send(frame(1, 5));
    expect(await requested('pace')).toMatchObject({ value: { paused: true } });
    requests.length = 0;
    watch.setPaused(false);
    expect(await requested('pace')).toMatchObject({ value: { paused: false } });
  });

  it('says no to a grab before there is a connection', async () => {
    expect(open().send({ case: 'release', value: { grabId: 'g' } })).toBe(false);
    await requested('start');
  });
});
