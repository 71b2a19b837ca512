/** Address of a WebSocket of the server that this page comes from. */
export function streamUrl(path: 'watch' | 'images'): string {
  const { protocol, host } = location;
  return `${protocol === 'https:' ? 'wss' : 'ws'}://${host}/${path}`;
}
