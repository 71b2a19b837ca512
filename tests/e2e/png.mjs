// Reads PNG files of 8 bits a channel that are not interlaced, as Chromium writes them.
import { inflateSync } from 'node:zlib';

const kChannels = { 0: 1, 2: 3, 4: 2, 6: 4 };

function paeth(left, above, corner) {
  const toLeft = Math.abs(above - corner);
  const toAbove = Math.abs(left - corner);
  const toCorner = Math.abs(left + above - 2 * corner);
  if (toLeft <= toAbove && toLeft <= toCorner) return left;
  return toAbove <= toCorner ? above : corner;
}

// Turns differences to neighbours into values, row by row and in place.
function undoFilters(data, height, stride, step) {
  for (let y = 0; y < height; ++y) {
    const row = y * (stride + 1) + 1;
    const filter = data[row - 1];
    for (let x = 0; filter !== 0 && x < stride; ++x) {
      const left = x >= step ? data[row + x - step] : 0;
      const above = y > 0 ? data[row + x - stride - 1] : 0;
      const corner = y > 0 && x >= step ? data[row + x - stride - 1 - step] : 0;
      data[row + x] += [left, above, (left + above) >> 1, paeth(left, above, corner)][filter - 1];
    }
  }
}

/** @returns width and height, and at(x, y): red, green and blue of a pixel, 0..255 */
export function readPng(file) {
  const [width, height, depth, kind, interlaced] = [
    file.readUInt32BE(16),
    file.readUInt32BE(20),
    file[24],
    file[25],
    file[28],
  ];
  const channels = kChannels[kind];
  if (depth !== 8 || !channels || interlaced) throw new Error(`a PNG of depth ${depth}, kind ${kind}, ${interlaced}`);
  const parts = [];
  for (let at = 8; at < file.length; ) {
    const length = file.readUInt32BE(at);
    if (file.toString('latin1', at + 4, at + 8) === 'IDAT') parts.push(file.subarray(at + 8, at + 8 + length));
    at += 12 + length;
  }
  const data = inflateSync(Buffer.concat(parts));
  const stride = channels * width;
  undoFilters(data, height, stride, channels);
  return {
    width,
    height,
    at(x, y) {
      const begin = y * (stride + 1) + 1 + x * channels;
      return channels < 3 ? [data[begin], data[begin], data[begin]] : [...data.subarray(begin, begin + 3)];
    },
  };
}
