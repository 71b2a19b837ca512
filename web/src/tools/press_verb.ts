/** The word for choosing a place: a mouse clicks, a finger taps. */
export function pressVerb(): 'Click' | 'Tap' {
  return globalThis.matchMedia?.('(hover: hover) and (pointer: fine)').matches ? 'Click' : 'Tap';
}
