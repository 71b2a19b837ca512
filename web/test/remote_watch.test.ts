// The page's and the worker's side of a stream, with a channel between them as between a page and its worker.
import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import type { AddressInfo } from 'node:net';
import { MessageChannel } from 'node:worker_threads';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { WebSocket as NodeWebSocket, WebSocketServer } from 'ws';
import { Encoding, FrameSchema, WatchRequestSchema, WatchResponseSchema } from '../src/gen/kerf/v1/stream_pb';
import type { Frame, WatchRequest } from '../src/gen/kerf/v1/stream_pb';
import { SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import { decodeRecording, encodeHeader } from '../src/stream/recording_format';
import { RemoteWatch } from '../src/stream/remote_watch';
import type { FrameCopy } from '../src/stream/sheet_copy';
import { SpareArrays } from '../src/stream/spare_arrays';
import type { ProbeRequest } from '../src/stream/watch';
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
  const onRecording = vi.fn();
  const onNews = vi.fn();
  const ticks: number[] = [];

  const tell = (kind: MessageInitShape<typeof WatchResponseSchema>['kind']) =>
    socket!.send(toBinary(WatchResponseSchema, create(WatchResponseSchema, { kind })));
  const send = (value: Frame) => tell({ case: 'frame', value });
  const open = (strains = false, goesOn = false, isPaused = false, probes?: ProbeRequest[]) => {
    const url = `ws://127.0.0.1:${(server.address() as AddressInfo).port}/watch`;
    const onFrame = ({ tick }: { tick: number }) => ticks.push(tick);
    const events = { onState, onRejection, onNews, onRecording, onFrame };
    const port = channel.port1 as unknown as Port<ToWorker, FromWorker>;
    const pace = { isPaused, maxRateHz: 0 };
    watch = new RemoteWatch(port, url, 'sheets/a', events, { strains, probes, goesOn, pace });
    return watch;
  };
  const requested = (kind: string) => vi.waitUntil(() => requests.find((request) => request.case === kind));

  beforeEach(async () => {
    requests.length = ticks.length = 0;
    onState.mockClear();
    onRecording.mockClear();
    onNews.mockClear();
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

  it('asks for probes and has their values, also after the sheet went back', async () => {
    const probes = [{ name: 'tip', points: [{ x: 0.5, y: 0 }] }];
    const watch = open(false, false, false, probes);
    expect(await requested('start')).toMatchObject({ value: { probes: [{ name: 'tip', points: [{ x: 0.5, y: 0 }] }] } });
    send(frame(1, 5, { probeValues: [1, NaN], probeColumns: ['tip.x', 'tip.y'] }));
    send(frame(2, 6, { probeValues: [2, 3] }));
    await vi.waitUntil(() => ticks.length === 2);
    expect([watch.copy!.probeColumns, watch.copy!.probeValues]).toEqual([['tip.x', 'tip.y'], [2, 3]]);
    send({ ...frame(1, 3, { probeValues: [4, 5] }), sequence: 3n, epoch: 'two' });
    await vi.waitUntil(() => ticks.length === 3);
    expect([watch.copy!.probeColumns, watch.copy!.probeValues]).toEqual([['tip.x', 'tip.y'], [4, 5]]);
    expect(watch.copy!.hasGoneBack).toBe(true);
  });

  it('has another copy of a sheet that goes back, with all that the worker decoded', async () => {
    const watch = open();
    await requested('start');
    send(frame(1, 5));
    send(frame(2, 9));
    await vi.waitUntil(() => ticks.length === 2);
    const before = watch.copy!;
    expect([before.epoch, before.hasGoneBack]).toEqual(['one', false]);
    send({ ...frame(1, 3), sequence: 3n, epoch: 'two' });
    await vi.waitUntil(() => ticks.length === 3);
    const after = watch.copy!;
    expect(after).not.toBe(before);
    expect([after.epoch, after.hasGoneBack, after.tick, after.topologyVersion]).toEqual(['two', true, 3, 1]);
    expect([...after.triangles]).toEqual([0, 1, 2]);
    expect([after.positions[0], before.tick]).toEqual([3, 9]);
    send(frame(4, 4));
    await vi.waitUntil(() => ticks.length === 4);
    expect(watch.copy).toBe(after);
  });

  it('gives arrays back with the acknowledgement, and frames to come are in those', async () => {
    const copyOf = vi.spyOn(SpareArrays.prototype, 'copyOf');
    const watch = open();
    await requested('start');
    for (let i = 1; i <= 20; ++i) {
      send(frame(i, i));
      await vi.waitUntil(() => ticks.length === i);
      watch.acknowledge();
      await vi.waitUntil(() => requests.filter((request) => request.case === 'ack').length === i);
    }
    // Positions are interpolated if frames come slowly.
    watch.copy!.advance(performance.now() + 10_000);
    expect(watch.copy!.positions[0]).toBe(20);
    const [spare] = copyOf.mock.contexts as SpareArrays[];
    expect(copyOf.mock.calls).toHaveLength(20);
    expect(spare.numAllocated).toBe(1);
    copyOf.mockRestore();
  });

  it('hears of the audience between frames, in the order of the stream, without a copy or an acknowledgement of it', async () => {
    const copyOf = vi.spyOn(SpareArrays.prototype, 'copyOf');
    const watch = open();
    expect(await requested('start')).toMatchObject({ value: { audience: true } });
    const heard: string[] = [];
    onNews.mockImplementation(({ case: kind }: { case: string }) => heard.push(`${kind} after ${ticks.length}`));
    tell({ case: 'audience', value: { viewers: [{ number: 2, tokenId: 'alice' }], numViewers: 1, ownNumber: 2 } });
    tell({ case: 'activity', value: { tokenId: 'alice', call: 'UndoCut' } });
    send(frame(1, 5));
    tell({ case: 'pointer', value: { viewer: 3, material: { x: 0.5, y: 0.25 } } });
    send(frame(2, 6));
    await vi.waitUntil(() => ticks.length === 2);
    expect(heard).toEqual(['audience after 0', 'activity after 0', 'pointer after 1']);
    expect(onNews.mock.calls[2][0].value).toMatchObject({ viewer: 3, material: { x: 0.5, y: 0.25 } });
    expect(copyOf).toHaveBeenCalledTimes(2);
    copyOf.mockRestore();
    watch.acknowledge();
    expect(await requested('ack')).toMatchObject({ value: { sequence: 2n } });
    tell({ case: 'pointer', value: { viewer: 3 } });
    await vi.waitUntil(() => heard.length === 4);
    watch.acknowledge();
    watch.send({ case: 'pointer', value: {} });
    await requested('pointer');
    expect(requests.map(({ case: kind }) => kind)).toEqual(['start', 'ack', 'pointer']);
    onNews.mockReset();
  });

  it('records from a stream that brings everything, and gives the file when it is stopped', async () => {
    const first = open();
    await requested('start');
    send(frame(1, 5));
    await vi.waitUntil(() => ticks.length === 1);
    first.record(encodeHeader(create(SheetSchema, { name: 'sheets/a' })), 1e6);
    requests.length = 0;
    const second = open(false, true);
    // Though it could continue from the triangles that are here.
    expect(await requested('start')).toMatchObject({ value: { epoch: '' } });
    send(frame(1, 8));
    send(frame(2, 9));
    await vi.waitUntil(() => ticks.length === 3);
    second.stopRecording();
    await vi.waitUntil(() => onRecording.mock.calls.some(([, parts]) => parts !== undefined));
    const [progress, parts] = onRecording.mock.calls.at(-1)!;
    expect(progress).toMatchObject({ numFrames: 2, isFull: false });
    const file = new Uint8Array(await new Blob(parts).arrayBuffer());
    const { sheet, messages } = decodeRecording(file);
    expect(sheet.name).toBe('sheets/a');
    const recorded = messages.map(({ bytes }) => fromBinary(WatchResponseSchema, bytes).kind.value as Frame);
    expect(recorded.map(({ tick }) => tick)).toEqual([8n, 9n]);
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
    watch.setPace({ isPaused: false, maxRateHz: 0 });
    expect(await requested('pace')).toMatchObject({ value: { paused: false } });
  });

  it('ends where its worker has failed, and says why', async () => {
    const watch = open();
    await requested('start');
    send(frame(1, 5));
    await vi.waitUntil(() => watch.state === 'live');
    watch.fail('out of memory');
    expect(onState.mock.calls.at(-1)).toEqual(['ended', 'out of memory']);
    expect([watch.state, watch.detail]).toEqual(['ended', 'out of memory']);
    expect(watch.send({ case: 'release', value: { grabId: 'g' } })).toBe(false);
  });

  it('ignores a frame and a state that are under way when it is closed, but not the file of a recording', () => {
    const asked: ToWorker[] = [];
    const port: Port<ToWorker, FromWorker> = { onmessage: null, postMessage: (message) => asked.push(message) };
    const onFrame = vi.fn();
    const events = { onState, onRejection, onNews, onRecording, onFrame };
    const options = { strains: false, goesOn: false, pace: { isPaused: false, maxRateHz: 0 } };
    const closed = new RemoteWatch(port, 'ws://a/watch', 'sheets/a', events, options);
    const { id } = asked[0] as ToWorker & { kind: 'start' };
    const arrive = (data: FromWorker) => port.onmessage!({ data } as MessageEvent<FromWorker>);
    arrive({ kind: 'state', id, state: 'live', detail: '' });
    expect(onState).toHaveBeenCalledTimes(1);
    closed.close();
    arrive({ kind: 'frame', id, frame: {} as FrameCopy, isFirst: true });
    arrive({ kind: 'state', id, state: 'ended', detail: 'gone' });
    expect(onFrame).not.toHaveBeenCalled();
    expect(onState).toHaveBeenCalledTimes(1);
    expect(closed.copy).toBeUndefined();
    const progress = { numFrames: 1, numBytes: 1, durationMs: 1, isFull: false };
    arrive({ kind: 'recorded', progress, parts: [] });
    expect(onRecording).toHaveBeenCalledWith(progress, []);
  });

  it('says no to a grab before there is a connection', async () => {
    expect(open().send({ case: 'release', value: { grabId: 'g' } })).toBe(false);
    await requested('start');
  });
});
