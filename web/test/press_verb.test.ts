import { afterEach, describe, expect, it, vi } from 'vitest';
import { pressVerb } from '../src/tools/press_verb';

describe('pressVerb', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('is Click for a mouse and Tap for a finger', () => {
    vi.stubGlobal('matchMedia', () => ({ matches: true }));
    expect(pressVerb()).toBe('Click');
    vi.stubGlobal('matchMedia', () => ({ matches: false }));
    expect(pressVerb()).toBe('Tap');
  });
});
