// Longest kerf.v1.CreateSheetRequest.sheet_id.
const kLongest = 63;

/** True if a sheet may have this id. */
export function isId(text: string): boolean {
  return text.length <= kLongest && /^[a-z][a-z0-9-]*$/.test(text);
}

/** Returns the id closest to the typed text: "My Flag!" -> "my-flag"; empty if the text has no letter. */
export function nearestId(text: string): string {
  const id = text.toLowerCase().replace(/[^a-z0-9]+/g, '-').replace(/^[^a-z]+|-+$/g, '');
  return id.slice(0, kLongest).replace(/-+$/, '');
}

/** Makes a sheet's id from the name of a file: "My Cloth.obj" -> "my-cloth"; empty if the name has no letter. */
export function idFrom(fileName: string): string {
  return nearestId(fileName.replace(/\.[^.]*$/, ''));
}

/** Returns `id`, or if it is taken, the first of id-2, id-3, ... that is not. */
export function freeId(id: string, taken: readonly string[]): string {
  for (let i = 1; ; ++i) {
    const end = i === 1 ? '' : `-${i}`;
    const candidate = `${id.slice(0, kLongest - end.length)}${end}`;
    if (!taken.includes(candidate)) return candidate;
  }
}
