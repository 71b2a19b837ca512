/** A drawing from a file, as a kerf.v1.Curve and InspectDrawing take it. */
export type DrawingContent =
  | { case: 'svg'; value: { text: string } }
  | { case: 'dxf'; value: { data: Uint8Array<ArrayBuffer> } };

// Larger files are compressed, so that the largest fits into a request.
const kLargeDxf = 512 * 1024;
const kBinary = 'AutoCAD Binary DXF';

/** Reads a file: SVG in any encoding or compressed by gzip, without embedded pictures and fonts, or DXF. */
export async function drawingContent(file: Blob): Promise<DrawingContent> {
  const data = await unpacked(new Uint8Array(await file.arrayBuffer()));
  if (isDxf(data)) return { case: 'dxf', value: { data: data.length > kLargeDxf ? await packed(data) : data } };
  return { case: 'svg', value: { text: withoutEmbeddedData(textOf(data)) } };
}

/** Empties data URIs, which hold pictures and fonts that are not cut. */
export function withoutEmbeddedData(text: string): string {
  return text.replace(/(["']\s*data:)[^"']*(?=["'])|(\(\s*data:)[^)]*(?=\))/g, (_, quoted?: string, bare?: string) => quoted ?? bare ?? '');
}

/** Decodes UTF-8 and UTF-16, the latter by its byte order mark, and all else as ISO-8859-1. */
export function textOf(data: Uint8Array): string {
  if (data[0] === 0xff && data[1] === 0xfe) return new TextDecoder('utf-16le').decode(data);
  if (data[0] === 0xfe && data[1] === 0xff) return new TextDecoder('utf-16be').decode(data);
  try {
    return new TextDecoder('utf-8', { fatal: true }).decode(data);
  } catch {
    return new TextDecoder('iso-8859-1').decode(data);
  }
}

function isDxf(data: Uint8Array): boolean {
  const start = new TextDecoder('iso-8859-1').decode(data.subarray(0, 32));
  return start.startsWith(kBinary) || /^AC10\d\d/.test(start) || /^(?:\u00ef\u00bb\u00bf)?\s*(?:999\s|0[ \t]*[\r\n])/.test(start);
}

async function packed(data: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([data]).stream().pipeThrough(new CompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function unpacked(data: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  if (data[0] !== 0x1f || data[1] !== 0x8b) return data;
  const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
