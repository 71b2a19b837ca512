import type { Curve, Path_Segment } from '../gen/kerf/v1/geometry_pb';
import { bezierPoint, ellipsePoints, flattened } from './curve';
import type { Point2 } from './locator';
import { svgArc } from './svg_arc';

const kMaxDepth = 9;
const kEllipseChords = 256;

/**
 * Returns polylines along a curve, in its own coordinates; none of a drawing that is still a file.
 * @param tolerance  largest distance between polyline and curve, in the curve's unit; ellipses have 256 chords
 */
export function curveLines({ kind }: Pick<Curve, 'kind'>, tolerance: number): Point2[][] {
  const bend = (points: readonly Point2[], weights?: readonly number[]) =>
    flattened((t) => bezierPoint(points, t, weights?.length ? weights : undefined), { tolerance, depth: kMaxDepth });
  const follow = (start: Point2, { kind: segment }: Path_Segment): Point2[] => {
    if (segment.case === 'line') return [start, segment.value];
    if (segment.case === 'quadratic' || segment.case === 'cubic') {
      const { end, weights } = segment.value;
      const controls =
        segment.case === 'cubic' ? [segment.value.control1, segment.value.control2] : [segment.value.control];
      return controls.every((point) => point) && end ? bend([start, ...(controls as Point2[]), end], weights) : [start];
    }
    if (segment.case !== 'arc' || !segment.value.end) return [start];
    const { semiAxisXM, semiAxisYM, rotationRad, large, counterClockwise, end } = segment.value;
    const turnDeg = (rotationRad * 180) / Math.PI;
    const arc = svgArc(start, end, [semiAxisXM, semiAxisYM, turnDeg, Number(large), Number(counterClockwise)]);
    return arc ? flattened(arc, { tolerance, depth: kMaxDepth }) : [start, end];
  };

  switch (kind.case) {
    case 'polyline':
      return [kind.value.points];
    case 'bezier': {
      const { points } = kind.value;
      const lines: Point2[][] = [];
      for (let i = 0; i + 3 < points.length; i += 3) lines.push(bend(points.slice(i, i + 4)));
      return lines;
    }
    case 'circle': {
      const { center = { x: 0, y: 0 }, radiusM: r } = kind.value;
      const { x, y } = center;
      return [ellipsePoints(center, { x: x + r, y }, { x, y: y + r }, kEllipseChords)];
    }
    case 'ellipse': {
      const { center = { x: 0, y: 0 }, semiAxisXM: a, semiAxisYM: b, rotationRad } = kind.value;
      const [cosine, sine] = [Math.cos(rotationRad), Math.sin(rotationRad)];
      const ends = [
        { x: center.x + a * cosine, y: center.y + a * sine },
        { x: center.x - b * sine, y: center.y + b * cosine },
      ];
      return [ellipsePoints(center, ends[0], ends[1], kEllipseChords)];
    }
    case 'path':
      return kind.value.subpaths.map(({ start = { x: 0, y: 0 }, segments, closed }) => {
        const line: Point2[] = [start];
        for (const segment of segments) line.push(...follow(line[line.length - 1], segment).slice(1));
        return closed ? [...line, start] : line;
      });
    default:
      return [];
  }
}
