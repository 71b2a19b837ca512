import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { CutLayerSchema, CutResultSchema, CutResult_Status, RemovedSchema } from '../src/gen/kerf/v1/cuts_pb';
import { areaText, cutDetails, cutText, lengthText, massText, warningText } from '../src/tools/cut_text';

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
  const applied = create(CutResultSchema, {
    status: CutResult_Status.APPLIED,
    tick: 480n,
    pieces: 2,
    newVertices: 175,
    deviationM: 3.9e-4,
  });

  it('says how many pieces there are, and the details the rest', () => {
    expect(cutText(applied)).toBe('Cut: 2 pieces');
    expect(cutDetails(applied)).toEqual(['The cut is at most 0.39 mm off the line', '175 new vertices, at tick 480']);
  });

  it('tells warnings apart', () => {
    expect(warningText({ ...applied, warnings: ['1 x text: not cut'] })).toBe('1 x text: not cut.');
    expect(warningText({ ...applied, warnings: ['1 x text: not cut', 'seen edge-on'] })).toBe('1 x text: not cut. Seen edge-on.');
    expect(warningText(applied)).toBe('');
  });

  it('has how many stretches a cut on a picture has in the details, when it is not one', () => {
    const layers = [0, 0].map((piece) => create(CutLayerSchema, { piece }));
    expect(cutDetails({ ...applied, layers })).toContain('The line crosses the sheet in 2 stretches');
    expect(cutDetails({ ...applied, layers: layers.slice(1) }).join()).not.toContain('stretches');
  });

  it('says what a cut with a width removed', () => {
    const removed = create(RemovedSchema, { areaM2: 0.0533, massKg: 0.0106 });
    expect(cutText({ ...applied, removed }, true)).toBe('Cut: 2 pieces, 533 cm² removed');
    expect(cutDetails({ ...applied, removed })).toContain('Removed: 11 g');
    expect(cutDetails({ ...applied, removed: { ...removed, pieces: 2 } })).toContain('Removed: 11 g, including 2 whole pieces');
  });

  it('says why a miss changed nothing', () => {
    const missed = create(CutResultSchema, { status: CutResult_Status.NO_INTERSECTION });
    expect(cutText(missed, true)).toBe('Nothing was cut: there is no material under the strip');
    expect(cutText(missed)).toBe('Nothing was cut: the line misses the sheet, or is too small');
    expect(cutText({ ...missed, closedGaps: 1 })).toBe('Nothing was cut: the line follows an older cut or the border');
    expect(cutDetails(missed)).toEqual([]);
  });

  it('ends each warning with one full stop', () => {
    const warnings = ['the sheet now falls behind: a tick takes 23 ms.', 'text is not cut'];
    expect(warningText(create(CutResultSchema, { warnings }))).toBe(
      'The sheet now falls behind: a tick takes 23 ms. Text is not cut.',
    );
  });
});
