// The page's and the worker's side of a stream of pictures, with a channel between them as between a page and its worker.
// What the browser decodes is played: a picture is a thing that is handed over and closed.
import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { AddressInfo } from 'node:net';
import { MessageChannel } from 'node:worker_threads';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { WebSocket as NodeWebSocket, WebSocketServer } from 'ws';
import { ImageCodec, WatchImagesRequestSchema, WatchImagesResponseSchema } from '../src/gen/kerf/v1/render_pb';
import type { Image, WatchImagesRequest } from '../src/gen/kerf/v1/render_pb';
import type { FromImages, ToImages } from '../src/stream/image_messages';
import { ImageService } from '../src/stream/image_service';
import type { DecoderEvents, Picture } from '../src/stream/picture_decoder';
import { RemoteImages } from '../src/stream/remote_images';
import type { Port } from '../src/stream/watch_messages';

Object.assign(globalThis, { WebSocket: NodeWebSocket });

type Kind = WatchImagesRequest['kind'];
type Asked<K> = Extract<Kind, { case: K }> extends { value: infer Value } ? Value : never;

const kView = { widthPx: 64, heightPx: 32 };

describe('RemoteImages', () => {
  let server: WebSocketServer;
  let channel: MessageChannel;
  let socket: NodeWebSocket;
  let images: RemoteImages | undefined;
  let requests: Kind[];
  let decoder: DecoderEvents | undefined;
  let decoded: number[];
  // Bytes of images for which the decoder throws, fails later, or gives no picture.
  const kThrows = 1;
  const kFails = 2;
  const kHeld = 3;
  let codecs: ImageCodec[];
  let arrived: number[];
  const onState = vi.fn();
  const onRefused = vi.fn();

  const makePicture = () => new MessageChannel().port1 as unknown as Picture;
  const makeDecoder = (codec: ImageCodec, events: DecoderEvents) => {
    codecs.push(codec);
    decoder = events;
    return {
      decode: ({ data, sequence }: Image) => {
        if (data[0] === kThrows) throw new Error('no key');
        if (data[0] === kFails) return queueMicrotask(() => events.onError('broken'));
        decoded.push(Number(sequence));
        if (data[0] !== kHeld) events.onPicture(makePicture(), Number(sequence));
      },
      close: () => {},
    };
  };

  const send = (sequence: number, { key = sequence === 1, data = 0, tick = 10 * sequence } = {}) => {
    const value = { sequence: BigInt(sequence), tick: BigInt(tick), key, data: Uint8Array.of(data) };
    const response = create(WatchImagesResponseSchema, { kind: { case: 'image', value } });
    socket.send(toBinary(WatchImagesResponseSchema, response));
  };
  const open = (isPaused = false) => {
    const url = `ws://127.0.0.1:${(server.address() as AddressInfo).port}/images`;
    const events = { onState, onRefused, onPicture: ({ sequence }: { sequence: number }) => arrived.push(sequence) };
    const options = { codec: ImageCodec.IMAGE_VP8, view: kView, pace: { isPaused, maxRateHz: 0 } };
    images = new RemoteImages(channel.port1 as unknown as Port<ToImages, FromImages>, url, 'sheets/a', events, options);
    return images;
  };
  const asked = <K extends NonNullable<Kind['case']>>(kind: K) =>
    requests.filter((request) => request.case === kind).map(({ value }) => value as Asked<K>);
  const untilAsked = (kind: NonNullable<Kind['case']>, count = 1) => vi.waitUntil(() => asked(kind).length >= count);
  const untilArrived = (count: number) => vi.waitUntil(() => arrived.length === count);

  beforeEach(async () => {
    [requests, decoded, codecs, arrived] = [[], [], [], []];
    onState.mockClear();
    onRefused.mockClear();
    server = new WebSocketServer({ port: 0, host: '127.0.0.1', handleProtocols: () => 'kerf.v1' });
    server.on('connection', (connection) => {
      socket = connection;
      connection.on('message', (bytes: Buffer) => requests.push(fromBinary(WatchImagesRequestSchema, bytes).kind));
    });
    await new Promise((resolve) => server.once('listening', resolve));
    channel = new MessageChannel();
    new ImageService(channel.port2 as unknown as Port<FromImages, ToImages>, makeDecoder);
  });

  afterEach(async () => {
    images?.close();
    server.clients.forEach((client) => client.terminate());
    server.close();
    // After the worker's side has read that the stream is closed.
    await new Promise((resolve) => setTimeout(resolve));
    channel.port1.close();
  });

  it('draws the newest picture alone, and acknowledges it once, when it is drawn', async () => {
    const images = open();
    await untilAsked('start');
    expect(asked('start')[0]).toMatchObject({ name: 'sheets/a', codec: ImageCodec.IMAGE_VP8, view: kView });
    send(1);
    send(2);
    await untilArrived(2);
    expect(images.state).toBe('live');
    const drawn: number[] = [];
    expect(images.draw(({ tick }) => drawn.push(tick))).toBe(true);
    expect(images.draw(({ tick }) => drawn.push(tick))).toBe(false);
    images.setView({ ...kView, wireframe: true });
    // Messages are in order: no other acknowledgement was on its way.
    await untilAsked('view');
    expect(drawn).toEqual([20]);
    expect(asked('ack')).toMatchObject([{ sequence: 2n }]);
    expect(asked('ack')[0].heldUs).toBeGreaterThan(0n);
    expect(asked('view')).toMatchObject([{ ...kView, wireframe: true }]);
  });

  it('tells what an image cost, and how many were not acknowledged', async () => {
    const images = open();
    await untilAsked('start');
    send(1);
    send(2);
    await untilArrived(2);
    let delivery;
    images.draw((shown) => (delivery = shown.delivery));
    expect(delivery).toMatchObject({ isKeyframe: false, numUnacknowledged: 2 });
    await untilAsked('ack');
    send(3, { key: true });
    await untilArrived(3);
    images.draw((shown) => (delivery = shown.delivery));
    expect(delivery).toMatchObject({ isKeyframe: true, numUnacknowledged: 1 });
  });

  it.each([
    ['throws', kThrows],
    ['fails by and by', kFails],
  ])('asks for a key image where the decoder %s, and uses up what comes until then', async (_, data) => {
    const images = open();
    await untilAsked('start');
    send(1);
    await untilArrived(1);
    images.draw(() => {});
    send(2, { data });
    await untilAsked('view');
    expect(asked('view')).toMatchObject([kView]);
    send(3);
    await vi.waitUntil(() => asked('ack').at(-1)?.sequence === 3n);
    send(4, { key: true });
    await untilArrived(2);
    expect([decoded, arrived]).toEqual([[1, 4], [1, 4]]);
    expect(onRefused).not.toHaveBeenCalled();
  });

  it('gives up where nothing can be decoded', async () => {
    open();
    await untilAsked('start');
    for (let sequence = 1; sequence <= 3; ++sequence) {
      send(sequence, { key: true, data: kThrows });
      if (sequence < 3) await untilAsked('view', sequence);
    }
    await vi.waitUntil(() => onRefused.mock.calls.length > 0);
    expect(onRefused.mock.calls).toEqual([['UNDECODABLE', 'no key']]);
    expect(images!.state).toBe('ended');
  });

  it.each([
    ['RENDERER_UNAVAILABLE', 'this server draws no pictures (none: no EGL)'],
    ['NO_VIDEO_CODEC', 'this server was built without VP8; request IMAGE_JPEG (1)'],
  ])('does not try again where the server says %s', async (code, message) => {
    open();
    await untilAsked('start');
    socket.close(1008, `${code}: ${message}`);
    await vi.waitUntil(() => onRefused.mock.calls.length > 0);
    expect(onRefused.mock.calls).toEqual([[code, message]]);
    expect(onState.mock.calls.length).toBeGreaterThan(0);
    expect(images!.state).toBe('ended');
  });

  it('tries again where the server has too many streams, with the view that is wanted by then', async () => {
    const images = open();
    await untilAsked('start');
    images.setView({ ...kView, wireframe: true });
    await untilAsked('view');
    socket.close(1008, 'TOO_MANY_IMAGE_STREAMS: this server has 64 image streams, which is its limit; try again later');
    await untilAsked('start', 2);
    expect(asked('start')[1]).toMatchObject({ view: { wireframe: true } });
    expect(codecs).toHaveLength(2);
    expect(onRefused).not.toHaveBeenCalled();
  });

  it('passes over pictures of a connection that was lost', async () => {
    const images = open();
    await untilAsked('start');
    send(1, { data: kHeld });
    await vi.waitUntil(() => decoded.length === 1);
    const late = decoder!;
    socket.terminate();
    await untilAsked('start', 2);
    send(1, { tick: 70 });
    await untilArrived(1);
    // One that no image of this connection has asked for.
    const picture = makePicture();
    const close = vi.spyOn(picture, 'close');
    late.onPicture(picture, 9);
    expect(close).toHaveBeenCalledOnce();
    images.draw(({ tick }) => expect(tick).toBe(70));
    await untilAsked('ack');
    expect(arrived).toEqual([1]);
  });

  it('asks for nothing while the page is hidden, also on a connection that begins then', async () => {
    const images = open(true);
    await untilAsked('start');
    send(1);
    await untilAsked('pace');
    expect(asked('pace')).toMatchObject([{ paused: true }]);
    images.setPace({ isPaused: false, maxRateHz: 0 });
    await untilAsked('pace', 2);
    expect(asked('pace')[1]).toMatchObject({ paused: false });
  });

  it('closes a picture that is under way when the stream is closed, and shows nothing of it', () => {
    const asked: ToImages[] = [];
    const port: Port<ToImages, FromImages> = { onmessage: null, postMessage: (message) => asked.push(message) };
    const onPicture = vi.fn();
    const options = { codec: ImageCodec.IMAGE_VP8, view: kView, pace: { isPaused: false, maxRateHz: 0 } };
    const closed = new RemoteImages(port, 'ws://a/images', 'sheets/a', { onState, onRefused, onPicture }, options);
    const { id } = asked[0];
    const picture = { close: vi.fn() };
    const arrive = (data: unknown) => port.onmessage!({ data } as MessageEvent<FromImages>);
    closed.close();
    arrive({ kind: 'picture', id, shown: { picture } });
    arrive({ kind: 'state', id, state: 'ended', detail: '' });
    expect(picture.close).toHaveBeenCalledTimes(1);
    expect(onPicture).not.toHaveBeenCalled();
    expect(onState).not.toHaveBeenCalled();
    expect(closed.draw(() => {})).toBe(false);
  });

  it('closes the pictures of the stream before', async () => {
    const first = open();
    await untilAsked('start');
    send(1);
    await untilArrived(1);
    first.close();
    const second = open();
    await untilAsked('start', 2);
    expect(first.draw(() => {})).toBe(false);
    expect(second.draw(() => {})).toBe(false);
    send(1, { tick: 30 });
    await untilArrived(2);
    second.draw(({ tick }) => expect(tick).toBe(30));
  });
});
