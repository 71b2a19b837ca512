import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { brotliCompressSync, constants, gzipSync } from 'node:zlib';

/** Smaller files are sent as they are: they fit into one packet anyway. */
export const kLeastBytes = 1024;

const kText = /\.(html|js|mjs|css|json|map|svg|txt|wasm|webmanifest)$/;

const kEncoders: [extension: string, encode: (content: Buffer) => Buffer][] = [
  [
    '.br',
    (content) =>
      brotliCompressSync(content, {
        params: {
          [constants.BROTLI_PARAM_MODE]: constants.BROTLI_MODE_TEXT,
          [constants.BROTLI_PARAM_QUALITY]: constants.BROTLI_MAX_QUALITY,
          [constants.BROTLI_PARAM_SIZE_HINT]: content.length,
        },
      }),
  ],
  ['.gz', (content) => gzipSync(content, { level: constants.Z_BEST_COMPRESSION })],
];

/**
 * Writes NAME.br and NAME.gz beside each text file of at least kLeastBytes below `folder`, where they are smaller.
 * kerfd answers with them. The same content gives the same bytes.
 */
export function precompress(folder: string): void {
  for (const entry of readdirSync(folder, { withFileTypes: true })) {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) precompress(path);
    if (!entry.isFile() || !kText.test(entry.name)) continue;
    const content = readFileSync(path);
    if (content.length < kLeastBytes) continue;
    for (const [extension, encode] of kEncoders) {
      const encoded = encode(content);
      if (encoded.length < content.length) writeFileSync(path + extension, encoded);
    }
  }
}
