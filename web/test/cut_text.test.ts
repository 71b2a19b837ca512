import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { CutResultSchema, CutResult_Status } from '../src/gen/kerf/v1/cuts_pb';
import { cutText, lengthText } from '../src/tools/cut_text';

describe('lengthText', () => {
  it('has two digits and a fitting unit, never an exponent', () => {
    expect([0, 3.92e-4, 0.0123, 9.9e-5, 1.04e-6, 4.56e-8, 3e-14].map(lengthText)).toEqual([
      '0 mm',
      '0.39 mm',
      '12 mm',
      '99 µm',
      '1 µm',
      '46 nm',
      'under 1 nm',
    ]);
  });
});

describe('cutText', () => {
  it('says what was cut, with the warnings of the server', () => {
    const result = create(CutResultSchema, {
      status: CutResult_Status.APPLIED,
      tick: 480n,
      pieces: 2,
      newVertices: 175,
      deviationM: 3.9e-4,
      warnings: ['1 gap closed'],
    });
    expect(cutText(result)).toBe('Cut at tick 480: 2 pieces, 175 new vertices, deviation 0.39 mm. 1 gap closed');
  });

  it('says that a miss changed nothing', () => {
    expect(cutText(create(CutResultSchema, { status: CutResult_Status.NO_INTERSECTION }))).toContain('nothing was cut');
  });
});
