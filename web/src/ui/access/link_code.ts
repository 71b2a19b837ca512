/** Takes the code of a link out of the page's address, where it must not stay. Returns '' if there is none. */
export function takeCode(): string {
  const { hash, pathname, search } = location;
  const found = /^#(?:.*&)?code=([^&]+)/.exec(hash);
  if (!found) return '';
  history.replaceState(history.state, '', `${pathname}${search}`);
  return found[1];
}
