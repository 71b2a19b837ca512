// The frames that tests/wire/golden_frames_test.cc wrote, in both encodings: the viewer holds the same after each.
import { fromBinary } from '@bufbuild/protobuf';
import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { WatchResponseSchema } from '../src/gen/kerf/v1/stream_pb';
import type { Frame } from '../src/gen/kerf/v1/stream_pb';
import { MirrorError, SheetMirror } from '../src/stream/mirror';
import { goldenMessages, kGoldenFolder } from './support/golden_messages';

function framesOf(name: string): Frame[] {
  return goldenMessages(name).map((message) => {
    const { kind } = fromBinary(WatchResponseSchema, message);
    if (kind.case !== 'frame') throw new Error(`${name} holds a ${kind.case}`);
    return kind.value;
  });
}

/** FNV-1a, 32 bits, over little-endian words. */
function hashOf(mirror: SheetMirror): string {
  let hash = 2166136261;
  const add = (words: ArrayLike<number>) => {
    for (let i = 0; i < words.length; ++i)
      for (let shift = 0; shift < 32; shift += 8) hash = Math.imul(hash ^ ((words[i] >>> shift) & 0xff), 16777619);
  };
  const { numVertices, numSlots } = mirror;
  add(mirror.quantisedPositions);
  add(mirror.triangles.subarray(0, 3 * numSlots));
  add(mirror.pieces.subarray(0, numSlots));
  if (mirror.strains) add(new Int32Array(mirror.strains.slice().buffer));
  add(new Int32Array(mirror.materialPositions.slice(0, 2 * numVertices).buffer));
  return (hash >>> 0).toString(16);
}

const hashes = readFileSync(new URL('hashes.txt', kGoldenFolder), 'utf8').trim().split('\n');

describe.each(['compact.bin', 'raw.bin'])('%s', (name) => {
  const frames = framesOf(name);

  it('gives the state that is written down after each frame', () => {
    const mirror = new SheetMirror();
    expect(
      frames.map((frame) => {
        mirror.apply(frame);
        return hashOf(mirror);
      }),
    ).toEqual(hashes);
  });

  it('is refused whole where bytes are missing, and goes on with the frame as it was', () => {
    const mirror = new SheetMirror();
    frames.forEach((frame, i) => {
      const before = i > 0 ? hashOf(mirror) : undefined;
      for (const field of ['positions', 'strains', 'triangles', 'pieces', 'slots', 'vertices', 'materialPositions'] as const) {
        const spoilt = { ...frame, topology: frame.topology && { ...frame.topology } };
        const holder = field === 'positions' || field === 'strains' ? spoilt : spoilt.topology;
        const bytes = (holder as unknown as Record<string, Uint8Array> | undefined)?.[field];
        if (!bytes || bytes.length === 0) continue;
        (holder as unknown as Record<string, Uint8Array>)[field] = bytes.subarray(0, -1);
        expect(() => mirror.apply(spoilt)).toThrow(MirrorError);
      }
      if (before) expect(hashOf(mirror)).toBe(before);
      mirror.apply(frame);
      expect(hashOf(mirror)).toBe(hashes[i]);
    });
  });
});

describe('compact frames', () => {
  it('take a fraction of the raw ones', () => {
    const size = (frames: Frame[]) => frames.reduce((sum, frame) => sum + frame.positions.length, 0);
    expect(size(framesOf('compact.bin'))).toBeLessThan(size(framesOf('raw.bin')));
  });
});
