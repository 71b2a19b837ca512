import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { DrawingReportSchema } from '../src/gen/kerf/v1/files_pb';
import { CutSchema } from '../src/gen/kerf/v1/scene_pb';
import type { Point2 } from '../src/geometry/locator';
import { inUnitBox } from '../src/geometry/svg_outline';
import { PictureDrawing } from '../src/tools/drawings/picture_drawing';

const at = (x: number, y: number): Point2 => ({ x, y });
const kSheet = { min: at(0, 0), max: at(2, 1) };

describe('inUnitBox', () => {
  it('turns the picture upright and keeps its shape', () => {
    const outline = inUnitBox([[at(10, 20), at(30, 20)], [at(10, 60)]])!;
    expect(outline.aspect).toBe(0.5);
    expect(outline.lines).toEqual([[at(0, 1), at(1, 1)], [at(0, 0)]]);
  });

  it('gives a straight line a box, and nothing none', () => {
    expect(inUnitBox([[at(0, 5), at(100, 5)]])!.aspect).toBeCloseTo(1000, 6);
    expect(inUnitBox([])).toBeUndefined();
    expect(inUnitBox([[at(3, 3)]])).toBeUndefined();
  });
});

describe('PictureDrawing', () => {
  const outline = inUnitBox([[at(0, 0), at(4, 0), at(4, 4), at(0, 4)]])!;
  const drawing = () => new PictureDrawing({ name: 'square.svg', content: { case: 'svg', value: { text: '<svg/>' } }, outline }, kSheet);
  const fit = (of: PictureDrawing) => create(CutSchema, of.cut()).fit!;

  it('is nothing without a file', () => {
    const empty = new PictureDrawing();
    expect([empty.isStarted, empty.isReady, empty.handles.length, empty.lines().length]).toEqual([false, false, 0, 0]);
  });

  it('is fitted into the middle of the sheet in its own shape, and sent with that box', () => {
    const laid = drawing();
    expect(create(CutSchema, laid.cut()).curve!.kind).toMatchObject({ case: 'svg', value: { text: '<svg/>' } });
    expect(fit(laid)).toMatchObject({ min: { x: 0.55, y: expect.closeTo(0.05) }, max: { x: 1.45, y: 0.95 } });
  });

  it('is moved by its middle and by a drag inside, not by one outside', () => {
    const laid = drawing();
    laid.moveHandle(4, at(0.5, 0.5));
    expect(fit(laid).min!.x).toBeCloseTo(0.05, 12);
    expect(laid.press(at(1.5, 0.5))).toBe(false);
    expect(laid.press(at(0.4, 0.4))).toBe(true);
    laid.drag(at(0.5, 0.3));
    laid.release();
    laid.drag(at(5, 5));
    expect(fit(laid)).toMatchObject({ min: { x: expect.closeTo(0.15), y: expect.closeTo(-0.05) } });
  });

  it('is scaled by each corner about the opposite one, in its own shape, and never turned over', () => {
    for (let corner = 0; corner < 4; ++corner) {
      const laid = drawing();
      const opposite = laid.handles[(corner + 2) % 4];
      const from = laid.handles[corner];
      const towards = (t: number) => at(opposite.x + t * (from.x - opposite.x), opposite.y + t * (from.y - opposite.y));
      laid.moveHandle(corner, towards(0.5));
      expect(laid.handles[corner].x).toBeCloseTo(towards(0.5).x, 12);
      expect(laid.handles[corner].y).toBeCloseTo(towards(0.5).y, 12);
      laid.moveHandle(corner, towards(-3));
      const { min, max } = fit(laid);
      expect(max!.x - min!.x).toBeCloseTo(0.02, 12);
      expect(max!.y - min!.y).toBeCloseTo(0.02, 12);
      expect(laid.handles[(corner + 2) % 4].x).toBeCloseTo(opposite.x, 12);
    }
  });

  it('shows its outline inside its box', () => {
    const laid = drawing();
    const [border, line] = laid.lines();
    expect(border.isGuide).toBe(true);
    expect(line.points[0]).toEqual(laid.handles[3]);
    expect(line.points[2]).toEqual(laid.handles[1]);
  });

  it('says so where there is no preview', () => {
    const unseen = new PictureDrawing({ name: 'odd.svg', content: { case: 'svg', value: { text: '' } }, outline: undefined }, kSheet);
    expect(unseen.prompt).toContain('odd.svg');
    expect(fit(unseen)).toMatchObject({ min: { x: expect.closeTo(0.1) }, max: { x: expect.closeTo(1.9) } });
  });

  const report = (width: number, height: number) =>
    create(DrawingReportSchema, { lines: 1, min: { x: 0, y: 0 }, max: { x: width, y: height } });

  it('takes its true size about its middle, and joins ends within a thousandth of its size', () => {
    const content = { case: 'dxf' as const, value: { data: new Uint8Array([48]) } };
    const laid = new PictureDrawing({ name: 'plate.dxf', content, outline, report: report(0.25, 0.25) }, kSheet);
    laid.takeTrueSize();
    expect(fit(laid)).toMatchObject({ min: { x: 0.875, y: 0.375 }, max: { x: 1.125, y: 0.625 } });
    const cut = create(CutSchema, laid.cut());
    expect(cut.joinM).toBeCloseTo(2.5e-4, 12);
    expect(cut.curve!.kind.case).toBe('dxf');
  });

  it('keeps scale and middle when another part is chosen', () => {
    const content = { case: 'svg' as const, value: { text: '<svg/>' } };
    const laid = new PictureDrawing({ name: 'a.svg', content, outline, report: report(0.2, 0.2) }, kSheet);
    const half = inUnitBox([[at(0, 0), at(4, 0), at(4, 2), at(0, 2)]])!;
    laid.replace({ name: 'a.svg', content, outline: half, only: 'stroke=red', report: report(0.1, 0.05) });
    expect(fit(laid)).toMatchObject({ min: { x: expect.closeTo(0.775) }, max: { x: expect.closeTo(1.225) } });
    expect(create(CutSchema, laid.cut()).curve!.kind.value).toMatchObject({ reading: { only: ['stroke=red'] } });
  });
});
