import { bytesText } from './statistics_text';

/** Downloads a file in the browser. Returns a message about it for the user. */
export function saveFile(parts: BlobPart[], name: string, mediaType: string): string {
  const blob = new Blob(parts, { type: mediaType });
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The browser has read the link by the next task, so the URL can be revoked then.
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
