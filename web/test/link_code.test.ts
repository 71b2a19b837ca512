import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { takeCode } from '../src/ui/access/link_code';

describe('takeCode', () => {
  const replaceState = vi.fn();
  const open = (address: string) => {
    const { pathname, search, hash } = new URL(address);
    vi.stubGlobal('location', { pathname, search, hash });
    return takeCode();
  };

  beforeEach(() => {
    replaceState.mockClear();
    vi.stubGlobal('history', { state: null, replaceState });
  });
  afterEach(() => vi.unstubAllGlobals());

  it('takes the code out of the address, and leaves the sheet there', () => {
    expect(open('https://host:8443/?sheet=demo#code=Ab-9_x')).toBe('Ab-9_x');
    expect(replaceState.mock.calls).toEqual([[null, '', '/?sheet=demo']]);
    expect(open('https://host/#theme=dark&code=abc')).toBe('abc');
  });

  it.each(['https://host/?sheet=demo', 'https://host/#encode=abc', 'https://host/#code=', 'https://host/?code=abc'])(
    'finds none in %s',
    (address) => {
      expect(open(address)).toBe('');
      expect(replaceState).not.toHaveBeenCalled();
    },
  );
});
