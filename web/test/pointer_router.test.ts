import { Ray, Vector2 } from 'three';
import { beforeEach, describe, expect, it } from 'vitest';
import type { Stage } from '../src/scene/stage';
import { KeyboardPointer } from '../src/tools/keyboard_pointer';
import { PointerRouter } from '../src/tools/pointer_router';
import type { Tool, Viewer } from '../src/tools/tool';
import { fakePage } from './support/fake_page';

// The area is its own canvas.
class FakeCanvas extends EventTarget {
  focus(): void {}
  setPointerCapture(): void {}
  getBoundingClientRect() {
    return { left: 0, top: 0 };
  }
}

describe('PointerRouter', () => {
  let done: string[];
  let canvas: FakeCanvas;
  let cross: KeyboardPointer;
  const point = (type: string, x: number, y: number) =>
    canvas.dispatchEvent(Object.assign(new Event(type), { pointerId: 1, button: 0, clientX: x, clientY: y }));

  beforeEach(() => {
    fakePage();
    done = [];
    canvas = new FakeCanvas();
    const tool = {
      press: () => done.push('press') > 0,
      drag: () => void done.push('drag'),
      release: () => void done.push('release'),
    } as unknown as Tool;
    const stage = { sizePx: new Vector2(400, 300), rayAt: () => new Ray() } as unknown as Stage;
    const viewer = { overlay: { append: () => {} }, stage, shown: {} } as unknown as Viewer;
    cross = new KeyboardPointer(viewer, () => tool);
    new PointerRouter(
      canvas as unknown as HTMLElement,
      canvas as unknown as HTMLCanvasElement,
      stage,
      () => tool,
      () => cross.hide(),
    );
  });

  it('lets go of what keys hold before the mouse presses', () => {
    cross.move(16, 0);
    cross.press();
    point('pointerdown', 10, 10);
    expect(done).toEqual(['press', 'release', 'press']);
  });

  it('leaves no place of the cross that Enter could mean once the mouse has drawn', () => {
    cross.move(16, 0);
    point('pointerdown', 10, 10);
    point('pointermove', 50, 50);
    point('pointerup', 50, 50);
    expect(cross.press()).toBe(false);
    expect(done).toEqual(['press', 'drag', 'release']);
  });
});
