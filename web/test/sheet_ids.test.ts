import { describe, expect, it } from 'vitest';
import { freeId, idFrom } from '../src/ui/sheets/sheet_ids';

describe('idFrom', () => {
  it('makes an id of what is in a name', () => {
    expect(idFrom('My Cloth (2).obj')).toBe('my-cloth-2');
    expect(idFrom('42 flag.svg')).toBe('flag');
    expect(idFrom('布.ply')).toBe('');
    expect(idFrom(`${'a'.repeat(80)}.obj`)).toHaveLength(63);
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
