import { beforeEach, describe, expect, it, vi } from 'vitest';
import { PointerDots, kOwnDot } from '../src/tools/pointer_dots';
import type { Viewer } from '../src/tools/tool';
import { StageFromAbove, flatSheet } from './support/flat_sheet';

// The part of an element that a dot uses.
class FakeDot {
  static readonly shown: FakeDot[] = [];
  className = '';
  textContent = '';
  hidden = false;
  isTurned = false;
  children: FakeDot[] = [];
  readonly style = { transform: '', setProperty: () => {} };
  readonly classList = { toggle: (_: string, isOn: boolean) => (this.isTurned = isOn) };
  setAttribute(): void {}
  append(...children: FakeDot[]): void {
    this.children.push(...children);
  }
  remove(): void {
    FakeDot.shown.splice(FakeDot.shown.indexOf(this), 1);
  }
}

describe('PointerDots', () => {
  let stage: StageFromAbove;
  let sheet: ReturnType<typeof flatSheet>;
  let shown: { surface: ReturnType<typeof flatSheet>['surface'] | undefined };
  let dots: PointerDots;
  const places = () => {
    dots.update();
    return FakeDot.shown.map(({ children, hidden, style }) =>
      hidden ? `${children[0].textContent} hidden` : `${children[0].textContent} ${style.transform}`,
    );
  };

  beforeEach(() => {
    FakeDot.shown.length = 0;
    vi.stubGlobal('document', { createElement: () => new FakeDot() });
    stage = new StageFromAbove();
    sheet = flatSheet();
    shown = { surface: sheet.surface };
    const overlay = { append: (dot: FakeDot) => FakeDot.shown.push(dot) };
    dots = new PointerDots({ overlay, stage, shown } as unknown as Viewer);
  });

  it('are where their points of the material are, also after the sheet has moved', () => {
    dots.set(3, 'alice', { x: 0.75, y: 0.25 });
    dots.set(4, 'bob', { x: 0.25, y: 0.75 });
    expect(places()).toEqual(['alice translate(75.0px, 25.0px)', 'bob translate(25.0px, 75.0px)']);
    // The corner at (1, 0) goes to (3, 0): the weights of alice's point are a half, of this corner, and two quarters.
    sheet.mirror.positions[3] = 3;
    expect(places()).toEqual(['alice translate(175.0px, 25.0px)', 'bob translate(25.0px, 75.0px)']);
  });

  it('move, and are drawn then, with the name once', () => {
    dots.set(3, 'alice', { x: 0.5, y: 0.5 });
    dots.set(3, 'alice', { x: 0.25, y: 0.5 });
    expect(stage.numInvalidated).toBe(2);
    expect(places()).toEqual(['alice translate(25.0px, 50.0px)']);
  });

  it('are hidden where no triangle is, behind the camera and before the first frame', () => {
    dots.set(3, 'alice', { x: 0.75, y: 0.25 });
    dots.set(4, 'bob', { x: 1.5, y: 0.5 });
    sheet.mirror.triangles.set([-1, -1, -1], 3);
    sheet.mirror.topologyVersion = 2;
    dots.set(5, 'carol', { x: 0.25, y: 0.75 });
    expect(places()).toEqual(['alice translate(75.0px, 25.0px)', 'bob hidden', 'carol hidden']);
    sheet.mirror.positions.set([9, 9, 9], 0);
    for (let v = 0; v < 4; ++v) sheet.mirror.positions[3 * v + 2] = 9;
    expect(places()).toEqual(['alice hidden', 'bob hidden', 'carol hidden']);
    shown.surface = undefined;
    expect(places()).toEqual(['alice hidden', 'bob hidden', 'carol hidden']);
  });

  it('vanish when their viewers leave or point nowhere; the one of the user stays', () => {
    const at = { x: 0.5, y: 0.5 };
    dots.set(kOwnDot, '', at);
    dots.set(3, 'alice', at);
    dots.set(4, 'bob', at);
    dots.keepOnly(new Set([4]));
    expect(FakeDot.shown.map(({ className }) => className)).toEqual(['pointer-dot own', 'pointer-dot']);
    dots.set(4, 'bob', undefined);
    dots.set(9, 'never there', undefined);
    expect([FakeDot.shown.length, dots.isEmpty]).toEqual([1, false]);
    dots.clear();
    expect([FakeDot.shown.length, dots.isEmpty]).toEqual([0, true]);
  });

  it('have their names on the side where there is room', () => {
    dots.set(3, 'alice', { x: 0.9, y: 0.5 });
    dots.set(4, 'bob', { x: 0.1, y: 0.5 });
    dots.update();
    expect(FakeDot.shown.map(({ children }) => children[0].isTurned)).toEqual([true, false]);
  });
});
