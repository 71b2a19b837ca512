import { Quaternion, PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it, vi } from 'vitest';
import { lineMeasures, measureText, pieceMeasures, stretchText } from '../src/tools/measures';
import { axisPlace, kSides } from '../src/ui/axis_gizmo';
import { measurePrompt } from '../src/ui/measure_panel';
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
    [0, '0 m'],
    [1.23456, '1.235 m'],
    [0.32104, '32.1 cm'],
    [0.0012345, '1.234 mm'],
  ])('of %f m are read as %s', (metres, text) => {
    expect(measureText(metres)).toBe(text);
  });

  it.each([
    [1, '0 %'],
    [1.0002, '0 %'],
    [0.95, '−5 %'],
    [1.0123, '+1.2 %'],
  ])('of a line stretched to %f are %s', (spaceM, text) => {
    expect(stretchText({ spaceM, sheetM: 1 })).toBe(text);
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
