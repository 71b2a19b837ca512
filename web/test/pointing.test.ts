import { Vector2 } from 'three';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Point2 } from '../src/geometry/locator';
import { Pointing } from '../src/tools/pointing';
import type { Viewer } from '../src/tools/tool';
import { StageFromAbove, flatSheet } from './support/flat_sheet';

class FakeArea extends EventTarget {
  getBoundingClientRect() {
    return { left: 10, top: 20 };
  }
}

describe('Pointing', () => {
  let area: FakeArea;
  let sheet: ReturnType<typeof flatSheet>;
  let live: { watch: { send: (request: { value: { material?: Point2 } }) => boolean } | undefined };
  let isConnected: boolean;
  let cross: Vector2 | undefined;
  let page: { hidden: boolean };
  let pointing: Pointing;
  // Times and places that were sent; "nowhere" if none is pointed at.
  let sent: [ms: number, place: string][];
  let pointed: (Point2 | undefined)[];
  const notify = vi.fn();
  const onToggled = vi.fn();
  const text = (at: Point2 | undefined) => (at ? `${at.x.toFixed(3)}, ${at.y.toFixed(3)}` : 'nowhere');
  const places = () => sent.map(([, place]) => place);
  const point = (type: string, x = 0, y = 0) =>
    area.dispatchEvent(Object.assign(new Event(type), { clientX: x + 10, clientY: y + 20 }));
  const pass = (ms: number) => vi.advanceTimersByTime(ms);

  beforeEach(() => {
    vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'performance'] });
    notify.mockReset();
    onToggled.mockReset();
    [sent, pointed, cross, isConnected] = [[], [], undefined, true];
    page = { hidden: false };
    vi.stubGlobal('document', page);
    area = new FakeArea();
    sheet = flatSheet();
    const send = ({ value }: { value: { material?: Point2 } }) => {
      if (isConnected) sent.push([performance.now(), text(value.material)]);
      return isConnected;
    };
    live = { watch: { send } };
    const viewer = { stage: new StageFromAbove(), shown: { surface: sheet.surface }, live, notices: { notify } };
    pointing = new Pointing(area as unknown as HTMLElement, viewer as unknown as Viewer, {
      onToggled,
      onPointed: (material) => void pointed.push(material),
      cross: () => cross,
    });
  });

  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it('sends nothing until it is on, then the place that is under the mouse', () => {
    point('pointermove', 25, 75);
    pass(1000);
    expect(sent).toEqual([]);
    pointing.toggle();
    pass(0);
    expect(places()).toEqual(['0.250, 0.750']);
    expect(pointed.map(text)).toEqual(['0.250, 0.750']);
    expect([pointing.isOn, onToggled.mock.calls]).toEqual([true, [[true]]]);
  });

  it('sends at most 20 places a second, and the last one', () => {
    pointing.toggle();
    for (let ms = 0; ms < 2000; ms += 5) {
      point('pointermove', 10 + ms / 40, 50);
      pass(5);
    }
    point('pointermove', 90, 50);
    pass(1000);
    const times = sent.map(([ms]) => ms);
    const gaps = times.slice(1).map((ms, i) => ms - times[i]);
    expect(Math.min(...gaps)).toBeGreaterThanOrEqual(50);
    expect(sent.length).toBeGreaterThan(20);
    expect(places().at(-1)).toBe('0.900, 0.500');
  });

  it('sends a place once, and again if the sheet moves under a mouse that does not', () => {
    pointing.toggle();
    point('pointermove', 50, 50);
    for (let i = 0; i < 10; ++i) {
      pass(100);
      pointing.update();
    }
    expect(places()).toEqual(['0.500, 0.500']);
    for (let v = 0; v < 4; ++v) sheet.mirror.positions[3 * v] -= 0.25;
    pointing.update();
    pass(100);
    expect(places()).toEqual(['0.500, 0.500', '0.750, 0.500']);
  });

  it('looks for the place no more often than it sends', () => {
    const pick = vi.spyOn(sheet.surface, 'pick');
    pointing.toggle();
    point('pointermove', 50, 50);
    for (let ms = 0; ms < 600; ++ms) {
      pointing.update();
      pass(1);
    }
    expect(pick.mock.calls.length).toBeLessThanOrEqual(12);
  });

  it.each([
    ['the mouse leaves', () => point('pointerleave')],
    ['a gesture is cancelled', () => point('pointercancel')],
    ['the mouse is beside the sheet', () => point('pointermove', 150, 50)],
    ['it is turned off', () => pointing.toggle()],
    [
      'the page is hidden',
      () => {
        page.hidden = true;
        pointing.update();
      },
    ],
    [
      'the sheet is cut away there',
      () => {
        sheet.mirror.triangles.fill(-1);
        pointing.update();
      },
    ],
  ])('points nowhere, and says so once, when %s', (_, stop) => {
    pointing.toggle();
    point('pointermove', 50, 50);
    pass(100);
    stop();
    pass(100);
    pointing.update();
    pass(1000);
    expect(places()).toEqual(['0.500, 0.500', 'nowhere']);
    expect(pointed.map(text)).toEqual(['0.500, 0.500', 'nowhere']);
  });

  it('points where the cross of the keys is', () => {
    cross = new Vector2(20, 30);
    point('pointermove', 50, 50);
    pointing.toggle();
    pass(0);
    expect(places()).toEqual(['0.200, 0.300']);
  });

  it('points also where a tool drags, though the tool keeps the event to itself', () => {
    pointing.toggle();
    point('pointerdown', 40, 40);
    pass(0);
    expect(places()).toEqual(['0.400, 0.400']);
  });

  it('says the place again on the next connection, and shows none until then', () => {
    pointing.toggle();
    point('pointermove', 50, 50);
    pass(100);
    isConnected = false;
    pointing.begin();
    pointing.update();
    pass(100);
    expect(pointed.map(text)).toEqual(['0.500, 0.500', 'nowhere']);
    isConnected = true;
    pointing.update();
    pass(100);
    expect(places()).toEqual(['0.500, 0.500', '0.500, 0.500']);
    expect(pointed.map(text)).toEqual(['0.500, 0.500', 'nowhere', '0.500, 0.500']);
  });

  it('cannot be turned on without a live sheet, but be turned off', () => {
    live.watch = undefined;
    pointing.toggle();
    expect([pointing.isOn, notify.mock.calls.length]).toEqual([false, 1]);
    live.watch = { send: () => true };
    pointing.toggle();
    live.watch = undefined;
    pointing.toggle();
    expect([pointing.isOn, notify.mock.calls.length]).toEqual([false, 1]);
  });
});
