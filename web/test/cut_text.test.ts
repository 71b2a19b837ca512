import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { CutResultSchema, CutResult_Status } from '../src/gen/kerf/v1/cuts_pb';
import { cutText, lengthText, warningText } from '../src/tools/cut_text';

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
  it('says what was cut; warnings are told apart', () => {
    const result = create(CutResultSchema, {
      status: CutResult_Status.APPLIED,
      tick: 480n,
      pieces: 2,
      newVertices: 175,
      deviationM: 3.9e-4,
      warnings: ['1 gap closed'],
    });
    expect(cutText(result)).toBe('Cut at tick 480: 2 pieces, 175 new vertices, deviation 0.39 mm');
    expect(warningText(result)).toBe('1 gap closed.');
    result.warnings.push('segments merged: 2');
    expect(warningText(result)).toBe('1 gap closed. Segments merged: 2.');
    expect(warningText(create(CutResultSchema, {}))).toBe('');
  });

  it('says how many stretches a cut on a picture has, when it is not one', () => {
    const result = create(CutResultSchema, {
      status: CutResult_Status.APPLIED,
      tick: 7n,
      pieces: 1,
      newVertices: 1,
      layers: [{ piece: 0 }, { piece: 0 }],
    });
    expect(cutText(result)).toBe('Cut at tick 7 in 2 stretches: 1 piece, 1 new vertex, deviation 0 mm');
  });

  it('says that a miss changed nothing', () => {
    expect(cutText(create(CutResultSchema, { status: CutResult_Status.NO_INTERSECTION }))).toContain('Nothing was cut');
  });
});
