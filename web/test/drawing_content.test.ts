import { gzipSync } from 'node:zlib';
import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { DrawingReportSchema } from '../src/gen/kerf/v1/files_pb';
import { drawingContent, withoutEmbeddedData } from '../src/tools/drawings/drawing_content';
import { reportText } from '../src/tools/drawings/picture_reader';

const kText = '<svg id="Größe"/>';

describe('drawingContent', () => {
  const textOf = async (data: Uint8Array) => {
    const content = await drawingContent(new Blob([data as BlobPart]));
    return content.case === 'svg' ? content.value.text : undefined;
  };
  const utf16 = (isBig: boolean) => {
    const data = new Uint8Array(2 * kText.length + 2);
    const view = new DataView(data.buffer);
    ['\ufeff', ...kText].forEach((c, i) => view.setUint16(2 * i, c.charCodeAt(0), !isBig));
    return data;
  };

  it('understands encodings and gzip', async () => {
    const utf8 = new TextEncoder().encode(kText);
    expect(await textOf(utf8)).toBe(kText);
    expect(await textOf(new Uint8Array([0xef, 0xbb, 0xbf, ...utf8]))).toBe(kText);
    expect(await textOf(Uint8Array.from(kText, (c) => c.charCodeAt(0)))).toBe(kText);
    expect(await textOf(utf16(true))).toBe(kText);
    expect(await textOf(utf16(false))).toBe(kText);
    expect(await textOf(new Uint8Array(gzipSync(utf8)))).toBe(kText);
  });

  it('tells DXF from SVG', async () => {
    for (const text of ['0\nSECTION\n', '  0\r\nSECTION\r\n', '999\nmade by hand\n', 'AutoCAD Binary DXF\r\n', 'AC1027x']) {
      expect((await drawingContent(new Blob([text]))).case, text).toBe('dxf');
    }
    for (const text of ['<svg/>', '', '0', '09']) expect((await drawingContent(new Blob([text]))).case, text).toBe('svg');
  });

  it('empties data URIs', () => {
    expect(withoutEmbeddedData(`<image href="data:image/png;base64,AAAA"/><style>a{src:url(data:font/woff;base64,BB)}</style>`)).toBe(
      '<image href="data:"/><style>a{src:url(data:)}</style>',
    );
    expect(withoutEmbeddedData('<text>data:no</text>')).toBe('<text>data:no</text>');
  });
});

describe('reportText', () => {
  it('says what a drawing has', () => {
    const groups = ['layer=Cut', 'layer=Fold', 'stroke=red', 'stroke=blue', '.a'].map((selector) => ({ selector, shapes: 1 }));
    const report = create(DrawingReportSchema, { lines: 3, min: { x: 0.01, y: 0 }, max: { x: 0.21, y: 0.1 }, groups, nearEnds: 2 });
    expect(reportText(report)).toBe(
      '200 x 100 mm, 3 lines; layers Cut, Fold; colours red, blue; 2 ends nearly meet another line and will be joined',
    );
  });
});
