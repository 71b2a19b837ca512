import { Vector3 } from 'three';
import type { Point2 } from '../geometry/locator';
import type { Surface } from '../geometry/surface';

/** The piece at a point. */
export interface PieceMeasures {
  /** Area, m²: of the undeformed sheet, and as it hangs now. */
  restM2: number;
  nowM2: number;
}

/** Lengths of the straight line between two points, metres: in space, and on the undeformed sheet. */
export interface LineMeasures {
  spaceM: number;
  sheetM: number;
}

/** Returns the distances between two material points; undefined if one of them is not on the sheet any more. */
export function lineMeasures(surface: Surface, a: Point2, b: Point2): LineMeasures | undefined {
  const [from, to] = [surface.onSheet(a), surface.onSheet(b)];
  if (!from || !to) return undefined;
  return { spaceM: from.distanceTo(to), sheetM: Math.hypot(b.x - a.x, b.y - a.y) };
}

/** Returns the areas of the piece at a material point; undefined if the point is not on the sheet any more. */
export function pieceMeasures({ mirror, locator }: Surface, at: Point2): PieceMeasures | undefined {
  const place = locator.find(at);
  if (!place) return undefined;
  const label = mirror.pieces[place.slot];
  const { triangles, positions, materialPositions: m } = mirror;
  const [p, q, r] = [new Vector3(), new Vector3(), new Vector3()];
  const areas = { restM2: 0, nowM2: 0 };
  for (let slot = 0; slot < mirror.numSlots; ++slot) {
    if (mirror.pieces[slot] !== label || triangles[3 * slot] < 0) continue;
    const [a, b, c] = [triangles[3 * slot], triangles[3 * slot + 1], triangles[3 * slot + 2]];
    p.fromArray(positions, 3 * a);
    q.fromArray(positions, 3 * b).sub(p);
    r.fromArray(positions, 3 * c).sub(p);
    areas.nowM2 += 0.5 * q.cross(r).length();
    const [bx, by] = [m[2 * b] - m[2 * a], m[2 * b + 1] - m[2 * a + 1]];
    const [cx, cy] = [m[2 * c] - m[2 * a], m[2 * c + 1] - m[2 * a + 1]];
    areas.restM2 += 0.5 * Math.abs(bx * cy - by * cx);
  }
  return areas;
}

/** A unit of lengths, of which there are so many in a metre. */
export interface MeasureUnit {
  name: 'm' | 'cm' | 'mm';
  inOneM: number;
}

/** Returns the unit for a length: metres or a suitable smaller one. */
function unitFor(metres: number): MeasureUnit {
  if (metres >= 1 || metres === 0) return { name: 'm', inOneM: 1 };
  return metres >= 0.01 ? { name: 'cm', inOneM: 100 } : { name: 'mm', inOneM: 1000 };
}

/**
 * Returns the unit of all lengths and areas of a measurement: that of the line on the undeformed sheet, which stays the
 * same as the sheet moves. Without a line it suits the size of the piece.
 */
export function measureUnit(line: LineMeasures | undefined, piece: PieceMeasures | undefined): MeasureUnit {
  return unitFor(line?.sheetM || Math.sqrt(piece?.restM2 ?? 0));
}

// Formats a number with four digits, and commas between groups of three.
function fourDigits(value: number): string {
  return value.toLocaleString('en', { maximumSignificantDigits: 4 });
}

/** Formats a length with four digits. */
export function measureText(metres: number, { name, inOneM }: MeasureUnit): string {
  return `${fourDigits(inOneM * metres)} ${name}`;
}

/** Formats an area with four digits, in the square of the unit. */
export function measureAreaText(squareMetres: number, { name, inOneM }: MeasureUnit): string {
  return `${fourDigits(inOneM ** 2 * squareMetres)} ${name}²`;
}

/** Formats by how much the line is longer in space than on the sheet: "+1.2 %". */
export function stretchText({ spaceM, sheetM }: LineMeasures): string {
  if (sheetM === 0) return '';
  const percent = 100 * (spaceM / sheetM - 1);
  const digits = Math.abs(percent) < 0.05 ? 0 : Number(percent.toPrecision(2));
  return `${digits > 0 ? '+' : digits < 0 ? '−' : ''}${Math.abs(digits)} %`;
}
