// kerf.v1.CreateSheetRequest.sheet_id.
const kLongest = 63;

/** What of a file's name may be a sheet's id: "My Cloth.obj" -> "my-cloth"; empty where nothing may. */
export function idFrom(fileName: string): string {
  const stem = fileName.toLowerCase().replace(/\.[^.]*$/, '');
  return stem.replace(/[^a-z0-9]+/g, '-').replace(/^[^a-z]+|-+$/g, '').slice(0, kLongest);
}

/** `id`, or where one of `taken` is that already the first of id-2, id-3 ... that none is. */
export function freeId(id: string, taken: readonly string[]): string {
  for (let i = 1; ; ++i) {
    const end = i === 1 ? '' : `-${i}`;
    const candidate = `${id.slice(0, kLongest - end.length)}${end}`;
    if (!taken.includes(candidate)) return candidate;
  }
}
