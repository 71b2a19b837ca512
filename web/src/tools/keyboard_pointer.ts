import { Vector2 } from 'three';
import type { Pointer, Tool, Viewer } from './tool';

/** CSS pixels by which an arrow key moves the cross, without and with Shift. */
export const kCrossStep = 16;
export const kCrossFineStep = 2;

/** A cross on the picture that is moved by keys and controls the tool as a mouse does. */
export class KeyboardPointer {
  private px: Vector2 | undefined;
  private isHolding = false;
  // True if the cross has moved since its last press: Enter then acts at its place, and does not cut the drawing.
  private isFresh = false;
  private readonly cross = document.createElement('div');
  private readonly place = document.createElement('output');

  constructor(
    private readonly viewer: Pick<Viewer, 'overlay' | 'stage' | 'shown'>,
    private readonly tool: () => Tool,
  ) {
    this.cross.className = 'cross';
    this.cross.hidden = true;
    this.cross.append(this.place);
    viewer.overlay.append(this.cross);
  }

  /** Shows the cross, at first in the middle, and moves it, and what it holds, by CSS pixels. */
  move(dx: number, dy: number): void {
    const { sizePx } = this.viewer.stage;
    const from = this.px ?? sizePx.clone().multiplyScalar(0.5);
    this.px = new Vector2(
      Math.min(sizePx.x, Math.max(0, from.x + dx)),
      Math.min(sizePx.y, Math.max(0, from.y + dy)),
    );
    this.isFresh = true;
    if (this.isHolding) this.tool().drag(this.pointer(this.px));
    this.show(this.px);
  }

  /** Taps, or presses until the next call releases; false if the cross has not moved since the last call. */
  press(): boolean {
    if (!this.px || !(this.isFresh || this.isHolding)) return false;
    this.isFresh = false;
    if (this.isHolding) {
      this.isHolding = false;
      this.tool().release();
      return true;
    }
    const pointer = this.pointer(this.px);
    this.isHolding = this.tool().press(pointer);
    if (!this.isHolding) this.tool().tap(pointer);
    return true;
  }

  /** Hides the cross and releases what it holds; false if there is no cross. */
  hide(): boolean {
    if (!this.px) return false;
    if (this.isHolding) this.tool().release();
    this.isHolding = false;
    this.px = undefined;
    this.cross.hidden = true;
    return true;
  }

  /** Place of the cross, CSS pixels; undefined while there is none. */
  get at(): Vector2 | undefined {
    return this.px;
  }

  private pointer(px: Vector2): Pointer {
    return { px: px.clone(), ray: this.viewer.stage.rayAt(px) };
  }

  private show(px: Vector2): void {
    const material = this.viewer.shown.surface?.pick(this.viewer.stage.rayAt(px))?.material;
    const text = material ? `${material.x.toFixed(3)}, ${material.y.toFixed(3)} m` : 'beside the sheet';
    this.cross.hidden = false;
    this.cross.style.transform = `translate(${px.x.toFixed(1)}px, ${px.y.toFixed(1)}px)`;
    if (this.place.textContent !== text) this.place.textContent = text;
  }
}
