import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { CutResultSchema, CutResult_Status } from '../src/gen/kerf/v1/cuts_pb';
import { areaText, cutText, lengthText, massText, warningText } from '../src/tools/cut_text';

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

describe('areaText and massText', () => {
  it('have two digits, or all whole ones, and a fitting unit', () => {
    expect([1.04, 0.053245, 2.14e-4, 8e-6, 3e-9, 1e-16, 0].map(areaText)).toEqual([
      '1 m²',
      '532 cm²',
      '2.1 cm²',
      '8 mm²',
      '3,000 µm²',
      'under 0.01 µm²',
      '0 µm²',
    ]);
    expect([1.5, 0.1234, 0.0106, 8e-6, 4.9e-10, 0].map(massText)).toEqual([
      '1.5 kg',
      '123 g',
      '11 g',
      '8 mg',
      '0.49 µg',
      '0 µg',
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

  it('says what a cut with a width took away', () => {
    const result = create(CutResultSchema, {
      status: CutResult_Status.APPLIED,
      tick: 9n,
      pieces: 3,
      newVertices: 20,
      deviationM: 1e-3,
      removed: { areaM2: 0.0533, massKg: 0.0106 },
    });
    const cut = 'Cut at tick 9: 3 pieces, 20 new vertices, deviation 1 mm, 533 cm² (11 g) taken away';
    expect(cutText(result, true)).toBe(cut);
    result.removed!.pieces = 2;
    expect(cutText(result, true)).toBe(`${cut}, 2 whole pieces among it`);
  });

  it('says that a miss changed nothing', () => {
    const missed = create(CutResultSchema, { status: CutResult_Status.NO_INTERSECTION });
    expect(cutText(missed, true)).toBe('Nothing was cut: there is no material under the strip');
    expect(cutText(create(CutResultSchema, { status: CutResult_Status.NO_INTERSECTION }))).toContain('Nothing was cut');
  });
});
