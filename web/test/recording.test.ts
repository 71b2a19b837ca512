// Files of recorded frames: written, read, and played, with frames that a server has sent.
import { create } from '@bufbuild/protobuf';
import { MessageChannel } from 'node:worker_threads';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import { meshHash } from '../src/stream/mesh_hash';
import { SheetMirror } from '../src/stream/mirror';
import { decodeRecording, encodeHeader, encodeMessage, kRecordHeadBytes } from '../src/stream/recording_format';
import { Replay } from '../src/stream/replay';
import type { FromReplay, ToReplay } from '../src/stream/replay_messages';
import { ReplayPlayer } from '../src/stream/replay_player';
import { ReplayService } from '../src/stream/replay_service';
import { StreamRecorder } from '../src/stream/stream_recorder';
import type { Port } from '../src/stream/watch_messages';
import { goldenMessages } from './support/golden_messages';

const kMessages = goldenMessages('compact.bin');
const kHeader = encodeHeader(create(SheetSchema, { name: 'sheets/a', tickRateHz: 60 }));

/** A file of `connections` streams, each with all golden frames, ten milliseconds apart. */
function fileOf(connections = 1): Uint8Array<ArrayBuffer> {
  const recorder = new StreamRecorder(kHeader, 1e9);
  for (let i = 0; i < connections * kMessages.length; ++i) {
    recorder.add(kMessages[i % kMessages.length], i % kMessages.length === 0, 500 + 10 * i);
  }
  const parts = recorder.finish().map((part) => new Uint8Array(part));
  const file = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  parts.reduce((at, part) => (file.set(part, at), at + part.length), 0);
  return file;
}

describe('StreamRecorder', () => {
  it('waits for the first frame of a connection and counts what it keeps', () => {
    const recorder = new StreamRecorder(kHeader, 1e9);
    recorder.add(kMessages[2], false, 100);
    expect(recorder.progress).toMatchObject({ numFrames: 0, numBytes: kHeader.length });
    recorder.add(kMessages[0], true, 200);
    recorder.add(kMessages[1], false, 225);
    const numBytes = kHeader.length + 2 * kRecordHeadBytes + kMessages[0].length + kMessages[1].length;
    expect(recorder.progress).toEqual({ numFrames: 2, numBytes, durationMs: 25, isFull: false });
  });

  it('stops before the frame that would be beyond the limit, and keeps those before it whole', () => {
    const limit = kHeader.length + 2 * kRecordHeadBytes + kMessages[0].length + kMessages[1].length;
    for (const [bytes, numFrames] of [
      [limit - 1, 1],
      [limit, 2],
    ]) {
      const recorder = new StreamRecorder(kHeader, bytes);
      kMessages.forEach((message, i) => recorder.add(message, i === 0, i));
      expect(recorder.progress).toMatchObject({ numFrames, isFull: true });
      expect(recorder.finish().reduce((sum, part) => sum + part.byteLength, 0)).toBeLessThanOrEqual(bytes);
    }
  });
});

describe('a .kerfstream file', () => {
  it('is read as it was written', () => {
    const { sheet, messages, numTornBytes } = decodeRecording(fileOf());
    expect([sheet.name, sheet.tickRateHz, numTornBytes]).toEqual(['sheets/a', 60, 0]);
    expect(messages.map(({ atMs }) => atMs)).toEqual(kMessages.map((_, i) => 10 * i));
    messages.forEach(({ bytes }, i) => expect([...bytes]).toEqual([...kMessages[i]]));
  });

  it('that was not written to its end has the frames before that', () => {
    const file = fileOf();
    for (const numMissing of [1, kMessages.at(-1)!.length, kMessages.at(-1)!.length + 5]) {
      const { messages, numTornBytes } = decodeRecording(file.subarray(0, file.length - numMissing));
      expect(messages).toHaveLength(kMessages.length - 1);
      expect(numTornBytes).toBe(kRecordHeadBytes + kMessages.at(-1)!.length - numMissing);
    }
  });

  it('that is none, or breaks the format, is refused and says where', () => {
    const spoilt = (change: (view: DataView, file: Uint8Array) => void) => {
      const file = fileOf();
      change(new DataView(file.buffer), file);
      return () => decodeRecording(file);
    };
    const second = kHeader.length + kRecordHeadBytes + kMessages[0].length;
    expect(() => decodeRecording(new Uint8Array(15))).toThrow('does not begin with KERFSTRM');
    expect(spoilt((_, file) => (file[0] = 0))).toThrow('does not begin with KERFSTRM');
    expect(spoilt((view) => view.setUint32(8, 2, true))).toThrow('version 2; this viewer reads version 1');
    expect(spoilt((view) => view.setUint32(12, 1 << 30, true))).toThrow('ends within the description');
    expect(spoilt((_, file) => file.fill(0xff, 16, kHeader.length))).toThrow('description of the sheet cannot be read');
    expect(spoilt((view) => view.setUint32(second, 0, true))).toThrow(`message 2, at byte ${second}, has no bytes`);
    expect(spoilt((view) => view.setFloat64(second + 4, -1, true))).toThrow('message 2 came at -1 ms, after one at 0 ms');
    expect(spoilt((view) => view.setFloat64(second + 4, Number.NaN, true))).toThrow('message 2 came at NaN');
    expect(() => decodeRecording(kHeader)).toThrow('no complete frame');
  });
});

/** States of a mirror of the recorded stream after each frame. */
function statesOf(file: Uint8Array): string[] {
  const player = new ReplayPlayer(decodeRecording(file));
  return Array.from({ length: player.numFrames }, (_, i) => stateOf(player.seek(i).mirror));
}

function stateOf(mirror: SheetMirror): string {
  return [mirror.tick, meshHash(mirror), ...mirror.positions.subarray(0, 3 * mirror.numVertices)].join();
}

describe('ReplayPlayer', () => {
  // 16 connections: more frames than lie between two copies.
  const file = fileOf(16);
  const states = statesOf(file);

  it('shows the same frames in any order as one after the other', () => {
    expect(states).toHaveLength(16 * kMessages.length);
    const player = new ReplayPlayer(decodeRecording(file));
    player.seek(states.length - 1);
    for (let i = 0, at = 7; i < 200; ++i, at = (at * 31 + 17) % states.length) {
      expect(stateOf(player.seek(at).mirror)).toBe(states[at]);
    }
    expect([...player.ticks.subarray(0, kMessages.length)]).toEqual([
      ...player.ticks.subarray(kMessages.length, 2 * kMessages.length),
    ]);
  });

  it('names the frame that does not follow from those before it, or cannot be read', () => {
    const recording = decodeRecording(fileOf());
    const without = { ...recording, messages: recording.messages.filter((_, i) => i !== 1) };
    expect(() => new ReplayPlayer(without).seek(3)).toThrow(/^frame 2: frame 3 after frame 1$/);
    const late = { ...recording, messages: recording.messages.slice(1) };
    expect(() => new ReplayPlayer(late).seek(0)).toThrow(/^frame 1: frame 2 after frame 0$/);
    recording.messages[1].bytes = Uint8Array.of(255, 255);
    expect(() => new ReplayPlayer(recording).seek(2)).toThrow(/^frame 2 cannot be read/);
    recording.messages[0].bytes = new Uint8Array(0);
    expect(() => new ReplayPlayer(recording).seek(0)).toThrow('message 1 is not a frame');
  });
});

describe('Replay', () => {
  let channel: MessageChannel;
  const shown: number[] = [];
  const onFailed = vi.fn();

  function play(file: Uint8Array<ArrayBuffer>): { replay: Replay; opened: Promise<void> } {
    let onOpened = () => {};
    const opened = new Promise<void>((resolve) => (onOpened = resolve));
    const events = { onProgress: () => {}, onOpened, onFrame: () => shown.push(replay.index), onFailed };
    const replay = new Replay(channel.port1 as unknown as Port<ToReplay, FromReplay>, events, file.slice().buffer);
    return { replay, opened };
  }

  beforeEach(() => {
    shown.length = 0;
    onFailed.mockClear();
    channel = new MessageChannel();
    new ReplayService(channel.port2 as unknown as Port<FromReplay, ToReplay>);
  });

  afterEach(() => channel.port1.close());

  it('plays at its speed from frame to frame, and stops at the end', async () => {
    const { replay, opened } = play(fileOf());
    await opened;
    expect([replay.numFrames, replay.durationMs]).toEqual([kMessages.length, 10 * (kMessages.length - 1)]);
    replay.speed = 0.5;
    replay.togglePlaying();
    let nowMs = 1000;
    while (replay.isPlaying) {
      replay.advance(nowMs);
      // Each has come before the next is due.
      await vi.waitUntil(() => replay.index === Math.floor(replay.atMs / 10));
      nowMs += 5;
    }
    expect(shown).toEqual(kMessages.map((_, i) => i));
    expect(nowMs - 1000).toBe(20 * (kMessages.length - 1) + 5);
    replay.togglePlaying();
    expect([replay.isPlaying, replay.atMs]).toEqual([true, 0]);
  });

  it('steps, is dragged anywhere, and asks for one frame at a time', async () => {
    const { replay, opened } = play(fileOf(3));
    await opened;
    replay.step(1);
    replay.advance(0);
    await vi.waitUntil(() => replay.index === 1);
    // While one is on its way only the last place that was wanted counts.
    replay.seek(55);
    replay.advance(1);
    for (const atMs of [3, 17, 92]) {
      replay.seek(atMs);
      replay.advance(2);
    }
    await vi.waitUntil(() => replay.index === 5);
    replay.advance(3);
    await vi.waitUntil(() => replay.index === 9);
    replay.step(-1);
    expect(replay.atMs).toBe(80);
    replay.step(-1000);
    expect([replay.atMs, replay.isPlaying]).toEqual([0, false]);
    replay.seek(1e9);
    replay.step(1);
    expect(replay.atMs).toBe(replay.durationMs);
    expect(shown).toEqual([1, 5, 9]);
  });

  it('goes on from where it was when the page was hidden meanwhile', async () => {
    const { replay, opened } = play(fileOf(16));
    await opened;
    replay.togglePlaying();
    replay.advance(0);
    replay.advance(60_000);
    expect(replay.atMs).toBe(1000);
  });

  it('says why a file cannot be played', async () => {
    play(new Uint8Array(20));
    await vi.waitUntil(() => onFailed.mock.calls.length > 0);
    expect(onFailed).toHaveBeenCalledWith('it does not begin with KERFSTRM');
  });

  it('takes a frame that breaks the stream for a broken file before anything is shown', async () => {
    const first = encodeMessage({ atMs: 0, bytes: kMessages[0] });
    const third = encodeMessage({ atMs: 1, bytes: kMessages[2] });
    const file = new Uint8Array([...kHeader, ...first, ...third]);
    play(file);
    await vi.waitUntil(() => onFailed.mock.calls.length > 0);
    expect(onFailed.mock.calls[0][0]).toMatch(/^frame 2: /);
    expect(shown).toEqual([]);
  });
});
