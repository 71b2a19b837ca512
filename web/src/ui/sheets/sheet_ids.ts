// kerf.v1.CreateSheetRequest.sheet_id.
const kLongest = 63;

/** True if a sheet may have this id. */
export function isId(text: string): boolean {
  return text.length <= kLongest && /^[a-z][a-z0-9-]*$/.test(text);
}

/** The id that comes closest to the typed text: "My Flag!" -> "my-flag"; empty where no letter is in it. */
export function nearestId(text: string): string {
  const id = text.toLowerCase().replace(/[^a-z0-9]+/g, '-').replace(/^[^a-z]+|-+$/g, '');
  return id.slice(0, kLongest).replace(/-+$/, '');
}

/** Part of a file's name that may be a sheet's id: "My Cloth.obj" -> "my-cloth"; empty where nothing may. */
export function idFrom(fileName: string): string {
  return nearestId(fileName.replace(/\.[^.]*$/, ''));
}

/** `id`, or where one of `taken` is that already the first of id-2, id-3 ... that none is. */
export function freeId(id: string, taken: readonly string[]): string {
  for (let i = 1; ; ++i) {
    const end = i === 1 ? '' : `-${i}`;
    const candidate = `${id.slice(0, kLongest - end.length)}${end}`;
    if (!taken.includes(candidate)) return candidate;
  }
}
