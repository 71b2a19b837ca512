/** Returns the address of a WebSocket of this page's server. */
export function streamUrl(path: 'watch' | 'images'): string {
  const { protocol, host } = location;
  return `${protocol === 'https:' ? 'wss' : 'ws'}://${host}/${path}`;
}
