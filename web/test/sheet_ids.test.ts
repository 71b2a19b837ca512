import { describe, expect, it } from 'vitest';
import { freeId, idFrom, isId, nearestId } from '../src/ui/sheets/sheet_ids';

describe('idFrom', () => {
  it('makes an id of what is in a name', () => {
    expect(idFrom('My Cloth (2).obj')).toBe('my-cloth-2');
    expect(idFrom('42 flag.svg')).toBe('flag');
    expect(idFrom('布.ply')).toBe('');
    expect(idFrom(`${'a'.repeat(80)}.obj`)).toHaveLength(63);
  });
});

describe('isId', () => {
  it('is what the server takes', () => {
    expect(['a', 'flag-2', 'a'.repeat(63)].every(isId)).toBe(true);
    expect(['', '2a', '-a', 'A', 'a b', 'a_b', 'a'.repeat(64)].some(isId)).toBe(false);
  });

  it('is true of the nearest one to anything with a letter in it', () => {
    for (const text of ['My Flag!', '  x', '7 seas', `${'a'.repeat(62)} b`]) expect([text, isId(nearestId(text))]).toEqual([text, true]);
  });
});

describe('freeId', () => {
  it('is the wanted one, or the next that nobody has', () => {
    expect(freeId('fall', ['demo'])).toBe('fall');
    expect(freeId('fall', ['fall', 'fall-2', 'fall-4'])).toBe('fall-3');
  });

  it('stays as short as an id must be', () => {
    const long = 'a'.repeat(63);
    expect(freeId(long, [long])).toBe(`${'a'.repeat(61)}-2`);
  });
});
