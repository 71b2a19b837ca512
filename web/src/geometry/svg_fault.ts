/**
 * Says why a text is no SVG drawing, in words that follow the file's name: "is broken: ...". Undefined if it is one.
 */
export function svgFault(text: string): string | undefined {
  const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
  // Browsers report faults in a document of their own.
  const fault = parsed.querySelector('parsererror');
  if (fault) return faultText(fault.textContent ?? '');
  return parsed.documentElement.localName === 'svg' ? undefined : 'is not an SVG drawing';
}

/** @param report  text of a browser: "... error on line 3 at column 7: ..." or "... Line Number 3, Column 7: ..." */
export function faultText(report: string): string {
  const line = /line (?:number )?(\d+)/i.exec(report)?.[1];
  return `is broken: its text ${line ? `ends early or has an error in line ${line}` : 'ends early or has an error'}`;
}
