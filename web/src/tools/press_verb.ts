/** Returns the verb for choosing a place: "Click" with a mouse, "Tap" with a finger. */
export function pressVerb(): 'Click' | 'Tap' {
  return globalThis.matchMedia?.('(hover: hover) and (pointer: fine)').matches ? 'Click' : 'Tap';
}
