import { create } from '@bufbuild/protobuf';
import { afterEach, describe, expect, it, vi } from 'vitest';
import { SheetSchema, SofteningSchema } from '../src/gen/kerf/v1/sheets_pb';
import { SofteningNote, softeningText } from '../src/ui/physics/softening_note';
import { fakePage } from './support/fake_page';

function softening(factor: number, expectedErrorM: number, fits = true) {
  return create(SofteningSchema, { factor, expectedErrorM, fits });
}

describe('softeningText', () => {
  it('says nothing of a sheet that is as its material', () => {
    expect(softeningText(undefined)).toBe('');
    expect(softeningText(softening(1, 0))).toBe('');
    expect(softeningText(softening(1, 0, false))).toBe('');
  });

  it('says by what factor the membrane is softer, and the error in millimetres', () => {
    const text = softeningText(softening(16, 0.0020468));
    expect(text).toMatch(/ 16 times softer in its plane .*: 2 mm if /);
    expect(text).not.toMatch(/coarser/);
  });

  it.each([
    [0.0000081, '0.0081 mm'],
    [0.00084, '0.84 mm'],
    [0.0704, '70 mm'],
    [1.234, '1,200 mm'],
  ])('writes an error of %d m as %s', (metres, text) => {
    expect(softeningText(softening(2, metres))).toContain(`: ${text} if `);
  });

  it('says where even the softest sheet does not fit its tick', () => {
    expect(softeningText(softening(16, 0.002, false))).toMatch(/use a coarser mesh\.$/);
  });
});

describe('SofteningNote', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('is there while the sheet is softened, and gone when it is no longer', () => {
    const line = fakePage()('material-softening');
    const note = new SofteningNote();
    note.show(create(SheetSchema, { softening: softening(4, 0.0008) }));
    expect([line.hidden, line.textContent]).toEqual([false, softeningText(softening(4, 0.0008))]);
    note.show(create(SheetSchema, { softening: softening(1, 0) }));
    expect([line.hidden, line.textContent]).toEqual([true, '']);
    note.show(create(SheetSchema, {}));
    expect(line.hidden).toBe(true);
  });
});
