import { describe, expect, it } from 'vitest';
import { keptChoice } from '../src/ui/theme';

const keeping = (value: string | null) => ({ getItem: () => value });

describe('keptChoice', () => {
  it('is what was kept', () => {
    expect(keptChoice(keeping('dark'))).toBe('dark');
    expect(keptChoice(keeping('light'))).toBe('light');
  });

  it('is the system where nothing was kept, or nonsense, or nothing may be read', () => {
    expect(keptChoice(keeping(null))).toBe('system');
    expect(keptChoice(keeping('purple'))).toBe('system');
    expect(keptChoice(undefined)).toBe('system');
    const forbidden = {
      getItem: () => {
        throw new Error('SecurityError');
      },
    };
    expect(keptChoice(forbidden)).toBe('system');
  });
});
