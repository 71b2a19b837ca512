import { bytesText } from './statistics_text';

/** Hands a file to the browser's downloads. Returns what to say about it. */
export function saveFile(parts: BlobPart[], name: string, mediaType: string): string {
  const blob = new Blob(parts, { type: mediaType });
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The browser has taken the blob by the time that the next task runs.
  setTimeout(() => URL.revokeObjectURL(link.href));
  return `Saved ${name} (${bytesText(blob.size)})`;
}

/**
 * @param sheet      sheets/{sheet}
 * @param extension  without a dot
 */
export function fileName(sheet: string, tick: number, extension: string): string {
  return `${sheet.replace('sheets/', '') || 'sheet'}-${tick}.${extension}`;
}
