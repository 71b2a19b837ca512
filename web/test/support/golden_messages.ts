import { readFileSync } from 'node:fs';

/** Messages that tests/wire/golden_frames_test.cc wrote. */
export const kGoldenFolder = new URL('../../../tests/data/frames/', import.meta.url);

/** The WatchResponses of one of its files, in the order of their stream. */
export function goldenMessages(name: string): Uint8Array[] {
  const bytes = new Uint8Array(readFileSync(new URL(name, kGoldenFolder)));
  const lengths = new DataView(bytes.buffer);
  const messages: Uint8Array[] = [];
  for (let at = 0; at < bytes.length; ) {
    const length = lengths.getUint32(at, true);
    messages.push(bytes.subarray(at + 4, at + 4 + length));
    at += 4 + length;
  }
  return messages;
}
