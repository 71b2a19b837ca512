import { Quaternion, PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it, vi } from 'vitest';
import { lineMeasures, measureAreaText, measureText, measureUnit, pieceMeasures, stretchText } from '../src/tools/measures';
import { axisPlace, kSides } from '../src/ui/axis_gizmo';
import { MeasurePanel, measurePrompt } from '../src/ui/measure_panel';
import { flatSheet } from './support/flat_sheet';

describe('measures', () => {
  // A square of which one half is folded up along the diagonal and lengthened.
  const { mirror, surface } = flatSheet();
  mirror.positions.set([0, 1, 1], 9);
  mirror.pieces = Int32Array.of(0, 0);

  it('are of the straight line in space and on the undeformed sheet', () => {
    const measures = lineMeasures(surface, { x: 0, y: 0 }, { x: 0, y: 1 })!;
    expect([measures.spaceM, measures.sheetM].map((metres) => metres.toFixed(6))).toEqual(['1.414214', '1.000000']);
    expect(stretchText(measures)).toBe('+41 %');
    expect(lineMeasures(surface, { x: 0, y: 0 }, { x: 2, y: 0 })).toBeUndefined();
  });

  it('are of the whole piece at a point, undeformed and now', () => {
    const { restM2, nowM2 } = pieceMeasures(surface, { x: 0.5, y: 0.25 })!;
    expect(restM2).toBeCloseTo(1);
    // The folded half has corners (0, 0, 0), (1, 1, 0) and (0, 1, 1).
    expect(nowM2).toBeCloseTo(0.5 + Math.sqrt(3) / 2);
    mirror.pieces = Int32Array.of(0, 1);
    expect(pieceMeasures(surface, { x: 0.25, y: 0.75 })!.restM2).toBeCloseTo(0.5);
    expect(pieceMeasures(surface, { x: -1, y: 0 })).toBeUndefined();
  });

  it.each([
    [1.23456, 1.1, 2.5, ['1.235 m', '1.1 m', '2.5 m²']],
    [0.32104, 0.3, 1.2, ['32.1 cm', '30 cm', '12,000 cm²']],
    [0.32104, 1, 0.0532, ['0.321 m', '1 m', '0.0532 m²']],
    [1.5, 0.999, 0.0532, ['150 cm', '99.9 cm', '532 cm²']],
    [0.0012344, 0.001, 0.00021, ['1.234 mm', '1 mm', '210 mm²']],
  ])('of %f m in space and %f m on a sheet of %f m² have one unit', (spaceM, sheetM, restM2, texts) => {
    const line = { spaceM, sheetM };
    const unit = measureUnit(line, { restM2, nowM2: 9 });
    expect([measureText(spaceM, unit), measureText(sheetM, unit), measureAreaText(restM2, unit)]).toEqual(texts);
    // Only the undeformed sheet decides, so that units stay as it moves.
    expect(measureUnit({ spaceM: 7, sheetM }, undefined)).toEqual(unit);
  });

  it.each([
    [1, '1 m²'],
    [0.9, '9,000 cm²'],
    [0.00001, '10 mm²'],
    [0, '0 m²'],
  ])('of a piece of %f m² alone are read as %s', (restM2, text) => {
    const piece = { restM2, nowM2: restM2 };
    expect(measureAreaText(restM2, measureUnit(undefined, piece))).toBe(text);
    expect(measureAreaText(restM2, measureUnit({ spaceM: 0, sheetM: 0 }, piece))).toBe(text);
  });

  it.each([
    [1, '0 %'],
    [1.0002, '0 %'],
    [0.95, '−5 %'],
    [1.0123, '+1.2 %'],
  ])('of a line stretched to %f are %s', (spaceM, text) => {
    expect(stretchText({ spaceM, sheetM: 1 })).toBe(text);
  });

  it('are shown in one unit and its square', () => {
    const shown = new Map<string, { textContent: string; parentElement: { hidden: boolean } }>();
    const getElementById = (id: string) => {
      if (!shown.has(id)) shown.set(id, { textContent: '', parentElement: { hidden: true } });
      return shown.get(id);
    };
    vi.stubGlobal('document', { getElementById });
    vi.stubGlobal('matchMedia', () => ({ matches: false }));
    const line = { spaceM: 1.2, sheetM: 0.5 };
    new MeasurePanel().show({ numPoints: 2, isGone: false, line, piece: { restM2: 1, nowM2: 0.05 } });
    expect(['space', 'sheet', 'rest', 'now'].map((id) => shown.get(`measure-${id}`)!.textContent)).toEqual([
      '120 cm',
      '50 cm',
      '10,000 cm²',
      '500 cm²',
    ]);
    vi.unstubAllGlobals();
  });

  it('prompts for what is missing', () => {
    vi.stubGlobal('matchMedia', () => ({ matches: false }));
    expect(measurePrompt({ numPoints: 0, isGone: false })).toMatch(/two points/);
    expect(measurePrompt({ numPoints: 1, isGone: false })).toMatch(/second point/);
    expect(measurePrompt({ numPoints: 2, isGone: true })).toMatch(/cut away/);
    vi.unstubAllGlobals();
  });
});

describe('axisPlace', () => {
  it('turns with the camera', () => {
    const camera = new PerspectiveCamera();
    camera.up.set(0, 0, 1);
    camera.position.set(0, -3, 0);
    camera.lookAt(new Vector3());
    const place = (side: string) => axisPlace(kSides[side], camera.quaternion);
    // Seen from the front x is to the right, z up, and −y nearest.
    expect([place('+x').x > 20, place('+z').y < -20, place('-y').depth > 0.99, place('+y').depth < -0.99]).toEqual([
      true,
      true,
      true,
      true,
    ]);
    expect(axisPlace(kSides['+z'], new Quaternion())).toMatchObject({ depth: 1 });
  });
});
