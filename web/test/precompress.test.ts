import { createHash } from 'node:crypto';
import { existsSync, mkdtempSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { brotliDecompressSync, gunzipSync } from 'node:zlib';
import { afterEach, beforeEach, describe, expect, it } from 'vitest';
import { kLeastBytes, precompress } from '../precompress';

describe('precompressed files', () => {
  let folder: string;
  const text = 'const sheet = "cut along the curve";\n'.repeat(200);
  beforeEach(() => {
    folder = mkdtempSync(join(tmpdir(), 'kerf-precompress-'));
    mkdirSync(join(folder, 'assets'));
  });
  afterEach(() => rmSync(folder, { recursive: true }));
  const write = (name: string, content: string | Buffer) => writeFileSync(join(folder, name), content);
  const read = (name: string) => readFileSync(join(folder, name));
  const isThere = (name: string) => existsSync(join(folder, name));

  it('stand beside text files, are smaller and unpack to the original', () => {
    write('index.html', text);
    write('assets/app-1a2b.js', text);
    precompress(folder);
    for (const name of ['index.html', 'assets/app-1a2b.js']) {
      expect(brotliDecompressSync(read(`${name}.br`)).toString()).toBe(text);
      expect(gunzipSync(read(`${name}.gz`)).toString()).toBe(text);
      expect(read(`${name}.gz`).length).toBeLessThan(text.length / 4);
      expect(read(name).toString()).toBe(text);
    }
  });

  it('have the same bytes each time', () => {
    write('index.html', text);
    precompress(folder);
    const first = ['index.html.br', 'index.html.gz'].map(read);
    precompress(folder);
    expect(['index.html.br', 'index.html.gz'].map(read)).toEqual(first);
    // Bytes 4 to 7 of a gzip file are a time, 0 where there is none.
    expect(first[1]!.readUInt32LE(4)).toBe(0);
  });

  it('are left out of small files, of pictures and of what does not become smaller', () => {
    write('small.css', 'a'.repeat(kLeastBytes - 1));
    write('least.css', 'a'.repeat(kLeastBytes));
    write('picture.png', text);
    const noise = Array.from({ length: 64 }, (_, i) => createHash('sha512').update(String(i)).digest());
    write('noise.txt', Buffer.concat(noise));
    precompress(folder);
    expect(isThere('least.css.br') && isThere('least.css.gz')).toBe(true);
    for (const name of ['small.css', 'picture.png', 'noise.txt']) {
      expect([name, isThere(`${name}.br`) || isThere(`${name}.gz`)]).toEqual([name, false]);
    }
    expect(isThere('least.css.br.gz')).toBe(false);
  });
});
