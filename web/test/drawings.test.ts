import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import type { Path } from '../src/gen/kerf/v1/geometry_pb';
import { CutSchema } from '../src/gen/kerf/v1/scene_pb';
import { bezierPoint } from '../src/geometry/curve';
import type { Point2 } from '../src/geometry/locator';
import { BezierDrawing } from '../src/tools/drawings/bezier_drawing';
import type { Drawing } from '../src/tools/drawings/drawing';
import { EllipseDrawing } from '../src/tools/drawings/ellipse_drawing';
import { FreehandDrawing } from '../src/tools/drawings/freehand_drawing';
import { LinesDrawing } from '../src/tools/drawings/lines_drawing';

const at = (x: number, y: number): Point2 => ({ x, y });

function distanceTo(line: readonly Point2[], p: Point2): number {
  const distances = line.slice(1).map((b, i) => {
    const a = line[i];
    const [dx, dy] = [b.x - a.x, b.y - a.y];
    const t = Math.min(1, Math.max(0, ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy || 1)));
    return Math.hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
  });
  return Math.min(...distances);
}

const kind = (drawing: Drawing) => create(CutSchema, drawing.cut()).curve!.kind;

function tapped<T extends Drawing>(drawing: T, ...points: Point2[]): T {
  for (const point of points) drawing.tap(point);
  return drawing;
}

function stroke<T extends Drawing>(drawing: T, points: readonly Point2[], tremor: number): T {
  expect(drawing.press(points[0])).toBe(true);
  for (const point of points.slice(1)) drawing.drag(point);
  expect(drawing.isReady).toBe(false);
  drawing.release(tremor);
  return drawing;
}

describe('BezierDrawing', () => {
  const segment = (drawing: Drawing) => {
    const { value } = kind(drawing) as { value: Path };
    expect(value.subpaths).toHaveLength(1);
    expect(value.subpaths[0].start).toMatchObject(drawing.handles[0]);
    expect(value.subpaths[0].segments).toHaveLength(1);
    return value.subpaths[0].segments[0].kind;
  };

  it('is quadratic with three points, cubic with four, and takes no fifth', () => {
    const drawing = tapped(new BezierDrawing(), at(0, 0), at(5, 9));
    expect(drawing.isReady).toBe(false);
    tapped(drawing, at(10, 0));
    expect(segment(drawing)).toMatchObject({
      case: 'quadratic',
      value: { control: at(5, 9), end: at(10, 0), weights: [] },
    });
    tapped(drawing, at(20, 0), at(30, 0));
    expect(segment(drawing)).toMatchObject({
      case: 'cubic',
      value: { control1: at(5, 9), control2: at(10, 0), end: at(20, 0) },
    });
    expect(drawing.handles).toHaveLength(4);
  });

  it('has a preview within 1/5000 of the box around its points', () => {
    const drawing = tapped(new BezierDrawing(), at(0, 0), at(300, 900), at(700, -500), at(1000, 0));
    const [, curve] = drawing.lines();
    for (let i = 0; i <= 1000; ++i) {
      const point = bezierPoint(drawing.handles, i / 1000);
      expect(distanceTo(curve.points, point)).toBeLessThan(1400 / 5000);
    }
  });

  it('is rational once a weight differs, and so is its preview', () => {
    const drawing = tapped(new BezierDrawing(), at(1, 0), at(1, 1), at(0, 1));
    drawing.weights[2] = 2;
    expect(segment(drawing)).toMatchObject({ value: { weights: [1, 1, 2] } });
    const [polygon, curve] = drawing.lines();
    expect(polygon.isGuide).toBe(true);
    for (const { x, y } of curve.points) expect(Math.hypot(x, y)).toBeCloseTo(1, 12);
  });

  it('takes the last point back with its weight', () => {
    const drawing = tapped(new BezierDrawing(), at(0, 0), at(1, 0), at(2, 1));
    expect(drawing.removeLast()).toBe(true);
    expect(drawing.handles).toHaveLength(2);
    expect(drawing.weights).toHaveLength(2);
  });

  it('moves as a whole or not at all', () => {
    const drawing = tapped(new BezierDrawing(), at(0, 0), at(1, 0), at(2, 1));
    expect(drawing.map(({ x, y }) => (x > 1 ? undefined : at(x, y + 5)))).toBe(false);
    expect(drawing.handles[0]).toEqual(at(0, 0));
    expect(drawing.map(({ x, y }) => at(x, y + 5))).toBe(true);
    expect(drawing.handles).toEqual([at(0, 5), at(1, 5), at(2, 6)]);
  });
});

describe('LinesDrawing', () => {
  it('is a polyline of at most as many points as the server takes', () => {
    const drawing = tapped(new LinesDrawing(), at(0, 0));
    expect(drawing.isReady).toBe(false);
    for (let i = 1; i < 5000; ++i) drawing.tap(at(i, 0));
    expect(kind(drawing)).toMatchObject({ case: 'polyline' });
    expect(drawing.handles).toHaveLength(4096);
  });
});

describe('FreehandDrawing', () => {
  it('is simplified to within the tremor', () => {
    const wave = Array.from({ length: 400 }, (_, i) => at(i, 40 * Math.sin(i / 60)));
    const drawing = stroke(new FreehandDrawing(), wave, 1.5);
    const { points } = drawing.lines()[0];
    expect(points.length).toBeLessThan(40);
    expect([points[0], points[points.length - 1]]).toEqual([wave[0], wave[399]]);
  });

  it('closes when it comes back to its start, exactly', () => {
    const loop = Array.from({ length: 100 }, (_, i) => at(80 * Math.cos(i / 16), 80 * Math.sin(i / 16)));
    const { points } = stroke(new FreehandDrawing(), loop, 1.5).lines()[0];
    expect(points[points.length - 1]).toEqual(points[0]);
    // Past its start it would cross itself.
    const past = Array.from({ length: 103 }, (_, i) => at(80 * Math.cos(i / 16), 80 * Math.sin(i / 16)));
    const trimmed = stroke(new FreehandDrawing(), past, 1.5).lines()[0].points;
    expect(trimmed[trimmed.length - 1]).toEqual(trimmed[0]);
    expect(trimmed[trimmed.length - 2].y).toBeLessThan(0);
    const open = stroke(new FreehandDrawing(), loop.slice(0, 80), 1.5).lines()[0];
    expect(open.points[open.points.length - 1]).not.toEqual(open.points[0]);
  });

  it('is cut as a smooth path, which is closed if the stroke is', () => {
    const around = (turns: number) =>
      Array.from({ length: 24 }, (_, i) => at(80 * Math.cos((turns * i) / 3.66), 80 * Math.sin((turns * i) / 3.66)));
    const cut = (turns: number) => (kind(stroke(new FreehandDrawing(), around(turns), 1.5)) as { value: Path }).value.subpaths[0];
    expect([cut(1).closed, cut(0.5).closed]).toEqual([true, false]);
    expect(cut(1).segments.every((segment) => segment.kind.case === 'cubic')).toBe(true);
    expect(cut(1).segments.length).toBeLessThan(9);
  });

  it('follows its plane, also to another unit', () => {
    const wave = Array.from({ length: 100 }, (_, i) => at(4 * i, 40 * Math.sin(i / 15)));
    const drawing = stroke(new FreehandDrawing(), wave, 1.5);
    const before = (kind(drawing) as { value: Path }).value.subpaths[0].segments.length;
    expect(drawing.map(({ x, y }) => at(x / 1000, y / 1000))).toBe(true);
    const { start, segments } = (kind(drawing) as { value: Path }).value.subpaths[0];
    expect(start).toMatchObject(at(0, 0));
    expect(Math.abs(segments.length - before)).toBeLessThanOrEqual(1);
    expect(drawing.map(() => undefined)).toBe(false);
  });

  it('never has more points than the server takes, and is nothing where the hand stayed', () => {
    const zigzag = Array.from({ length: 20_000 }, (_, i) => at(i / 10, i % 3 === 0 ? 0 : 40));
    const { value } = kind(stroke(new FreehandDrawing(), zigzag, 1.5)) as { value: Path };
    expect(value.subpaths[0].segments.length).toBeLessThan(10_000);
    expect(stroke(new FreehandDrawing(), [at(5, 5), at(5.5, 5)], 1.5).isStarted).toBe(false);
  });
});

describe('EllipseDrawing', () => {
  it('is a circle about the press through where it is let go', () => {
    const circle = stroke(new EllipseDrawing(true), [at(10, 20), at(12, 22), at(13, 24)], 1);
    expect(kind(circle)).toMatchObject({ case: 'circle', value: { center: at(10, 20), radiusM: 5 } });
    circle.moveHandle(0, at(0, 0));
    circle.moveHandle(1, at(0, 7));
    expect(kind(circle)).toMatchObject({ value: { center: at(0, 0), radiusM: 7 } });
    // Adjusted by its handles from here on: a press moves the view.
    expect(circle.press(at(0, 0))).toBe(false);
  });

  it('is an ellipse whose second axis stays at a right angle to the first', () => {
    const ellipse = stroke(new EllipseDrawing(false), [at(0, 0), at(10, 0)], 1);
    ellipse.moveHandle(2, at(0, 4));
    ellipse.moveHandle(1, at(0, 8));
    const { value } = kind(ellipse);
    expect(value).toMatchObject({ semiAxisXM: 8, semiAxisYM: 4, rotationRad: Math.PI / 2 });
    ellipse.map(({ x, y }) => at(x + 0.5 * y, y));
    const [center, first, second] = ellipse.handles;
    const across = (first.x - center.x) * (second.x - center.x) + (first.y - center.y) * (second.y - center.y);
    expect(across).toBeCloseTo(0, 12);
  });

  it('shows the line that it cuts', () => {
    const ellipse = stroke(new EllipseDrawing(false), [at(0, 0), at(3, 4)], 1);
    const { points } = ellipse.lines().find((line) => !line.isGuide)!;
    const { semiAxisXM: a, semiAxisYM: b, rotationRad: angle } = kind(ellipse).value as never as Record<string, number>;
    for (const { x, y } of points) {
      const [u, v] = [x * Math.cos(angle) + y * Math.sin(angle), y * Math.cos(angle) - x * Math.sin(angle)];
      expect((u / a) ** 2 + (v / b) ** 2).toBeCloseTo(1, 12);
    }
  });

  it('is nothing after a mere touch', () => {
    expect(stroke(new EllipseDrawing(true), [at(1, 1)], 1).isStarted).toBe(false);
  });
});
