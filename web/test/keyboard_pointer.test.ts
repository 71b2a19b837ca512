import { Ray, Vector2 } from 'three';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { KeyboardPointer } from '../src/tools/keyboard_pointer';
import type { Pointer, Tool, Viewer } from '../src/tools/tool';

// The part of an element that the cross uses.
const element = () => ({ className: '', hidden: false, textContent: '', style: {}, append: () => {} });
vi.stubGlobal('document', { createElement: element });

describe('KeyboardPointer', () => {
  let done: string[];
  let isTaken: boolean;
  let pointer: KeyboardPointer;
  const at = ({ px }: Pointer) => `${px.x},${px.y}`;
  const tool = {
    press: (pressed: Pointer) => {
      if (isTaken) done.push(`press ${at(pressed)}`);
      return isTaken;
    },
    drag: (dragged: Pointer) => void done.push(`drag ${at(dragged)}`),
    release: () => void done.push('release'),
    tap: (tapped: Pointer) => void done.push(`tap ${at(tapped)}`),
  } as unknown as Tool;
  const stage = { sizePx: new Vector2(400, 300), rayAt: () => new Ray() };

  beforeEach(() => {
    done = [];
    isTaken = false;
    const viewer = { overlay: { append: () => {} }, stage, shown: {} } as unknown as Viewer;
    pointer = new KeyboardPointer(viewer, () => tool);
  });

  it('starts in the middle and taps once where it came to', () => {
    expect(pointer.press()).toBe(false);
    pointer.move(16, 0);
    expect(pointer.press()).toBe(true);
    expect(pointer.press()).toBe(false);
    expect(done).toEqual(['tap 216,150']);
  });

  it('drags what a press took until the next one lets go', () => {
    isTaken = true;
    pointer.move(0, -10);
    pointer.press();
    pointer.move(5, 0);
    expect(pointer.press()).toBe(true);
    expect(done).toEqual(['press 200,140', 'drag 205,140', 'release']);
  });

  it('stays on the picture', () => {
    pointer.move(-1000, 1000);
    pointer.press();
    expect(done).toEqual(['tap 0,300']);
  });

  it('lets go of what it holds when it is taken away', () => {
    expect(pointer.hide()).toBe(false);
    isTaken = true;
    pointer.move(1, 1);
    pointer.press();
    expect(pointer.hide()).toBe(true);
    expect(done.at(-1)).toBe('release');
    expect(pointer.press()).toBe(false);
  });
});
