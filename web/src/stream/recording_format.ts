import { fromBinary, toBinary } from '@bufbuild/protobuf';
import { SheetSchema } from '../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';

// A .kerfstream file, all numbers little-endian:
//   8 bytes  "KERFSTRM"
//   uint32   version, 1
//   uint32   length of the kerf.v1.Sheet that follows: the sheet and its settings when the recording began
//   then for each frame:
//     uint32   length of the message, > 0
//     float64  arrival, milliseconds since the first message, never below the arrival of the message before
//     bytes    kerf.v1.WatchResponse with a frame
// A frame with sequence number 1 begins a connection: it is a keyframe with the full topology. The file's first frame
// is one.

const kMagic = 'KERFSTRM';
const kVersion = 1;
const kHeadBytes = 16;
export const kRecordHeadBytes = 12;

/** Thrown for a file that is no recording or violates the format. */
export class RecordingError extends Error {
  override readonly name = 'RecordingError';
}

export interface RecordedMessage {
  /** Arrival, milliseconds since the first message. */
  atMs: number;
  /** kerf.v1.WatchResponse */
  bytes: Uint8Array;
}

export interface Recording {
  sheet: Sheet;
  messages: RecordedMessage[];
  /** Bytes after the last whole message; they belong to a message that was not written completely. */
  numTornBytes: number;
}

/** Returns the first bytes of a file. */
export function encodeHeader(sheet: Sheet): Uint8Array<ArrayBuffer> {
  const body = toBinary(SheetSchema, sheet);
  const bytes = new Uint8Array(kHeadBytes + body.length);
  bytes.set(new TextEncoder().encode(kMagic));
  const view = new DataView(bytes.buffer);
  view.setUint32(8, kVersion, true);
  view.setUint32(12, body.length, true);
  bytes.set(body, kHeadBytes);
  return bytes;
}

export function encodeMessage({ atMs, bytes }: RecordedMessage): Uint8Array<ArrayBuffer> {
  const record = new Uint8Array(kRecordHeadBytes + bytes.length);
  const view = new DataView(record.buffer);
  view.setUint32(0, bytes.length, true);
  view.setFloat64(4, atMs, true);
  record.set(bytes, kRecordHeadBytes);
  return record;
}

function decodeSheet(bytes: Uint8Array): Sheet {
  try {
    return fromBinary(SheetSchema, bytes);
  } catch (error) {
    throw new RecordingError(`the description of the sheet cannot be read: ${(error as Error).message}`);
  }
}

/**
 * Splits a file into messages, which are views of `file` and not decoded.
 * @throws RecordingError
 */
export function decodeRecording(file: Uint8Array): Recording {
  if (file.length < kHeadBytes || new TextDecoder().decode(file.subarray(0, 8)) !== kMagic) {
    throw new RecordingError(`it does not begin with ${kMagic}`);
  }
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const version = view.getUint32(8, true);
  if (version !== kVersion) throw new RecordingError(`it has version ${version}; this viewer reads version ${kVersion}`);
  let at = kHeadBytes + view.getUint32(12, true);
  if (at > file.length) throw new RecordingError(`it ends within the description of the sheet, at byte ${file.length}`);
  const sheet = decodeSheet(file.subarray(kHeadBytes, at));
  const messages: RecordedMessage[] = [];
  let lastMs = 0;
  while (at + kRecordHeadBytes <= file.length) {
    const length = view.getUint32(at, true);
    const atMs = view.getFloat64(at + 4, true);
    if (length === 0) throw new RecordingError(`message ${messages.length + 1}, at byte ${at}, has no bytes`);
    if (!(atMs >= lastMs && Number.isFinite(atMs))) {
      throw new RecordingError(`message ${messages.length + 1} came at ${atMs} ms, after one at ${lastMs} ms`);
    }
    const begin = at + kRecordHeadBytes;
    if (begin + length > file.length) break;
    messages.push({ atMs, bytes: file.subarray(begin, begin + length) });
    lastMs = atMs;
    at = begin + length;
  }
  if (messages.length === 0) throw new RecordingError('it has no complete frame');
  return { sheet, messages, numTornBytes: file.length - at };
}
