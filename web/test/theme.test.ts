import { afterEach, describe, expect, it, vi } from 'vitest';
import { Theme, keptChoice } from '../src/ui/theme';

const keeping = (value: string | null) => () => ({ getItem: () => value });

describe('keptChoice', () => {
  it('is what was kept', () => {
    expect(keptChoice(keeping('dark'))).toBe('dark');
    expect(keptChoice(keeping('light'))).toBe('light');
  });

  it('is the system where nothing was kept, or nonsense, or nothing may be read', () => {
    expect(keptChoice(keeping(null))).toBe('system');
    expect(keptChoice(keeping('purple'))).toBe('system');
    const refuse = () => {
      throw new Error('SecurityError');
    };
    expect(keptChoice(() => ({ getItem: refuse }))).toBe('system');
    expect(keptChoice(refuse)).toBe('system');
  });
});

describe('Theme', () => {
  afterEach(() => {
    vi.unstubAllGlobals();
    Reflect.deleteProperty(globalThis, 'localStorage');
  });

  it('is the system’s, and can be changed, where the browser blocks what a site keeps', () => {
    Object.defineProperty(globalThis, 'localStorage', {
      configurable: true,
      get: () => {
        throw new Error('SecurityError');
      },
    });
    vi.stubGlobal('matchMedia', () => ({ matches: true, addEventListener: () => {} }));
    vi.stubGlobal('document', { documentElement: { dataset: {} } });
    const button = { querySelector: () => ({ setAttribute: () => {}, textContent: '' }) };
    const seen: boolean[] = [];
    const theme = new Theme(button as unknown as HTMLElement, (isDark) => seen.push(isDark));
    theme.next();
    expect(seen).toEqual([true, false]);
  });
});
