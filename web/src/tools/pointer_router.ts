import { Vector2 } from 'three';
import type { Stage } from '../scene/stage';
import type { Pointer, Tool } from './tool';

// A press that moves less than this, CSS pixels, is a tap.
const kTapReachPx = 6;

/** Gives pointer gestures on the canvas to the chosen tool; a gesture that the tool does not take moves the view. */
export class PointerRouter {
  private pressed: { id: number; start: Vector2; last: PointerEvent; isTaken: boolean; isTap: boolean } | undefined;
  private isHandingOver = false;

  /**
   * @param area         element around the canvas, which gets events before OrbitControls does
   * @param beforePress  called before the tool, or the view, gets a press
   */
  constructor(
    area: HTMLElement,
    private readonly canvas: HTMLCanvasElement,
    private readonly stage: Stage,
    private readonly tool: () => Tool,
    private readonly beforePress: () => void,
  ) {
    area.addEventListener('pointerdown', (event) => this.down(event), { capture: true });
    area.addEventListener('pointermove', (event) => this.move(event), { capture: true });
    area.addEventListener('pointerup', (event) => this.up(event, true), { capture: true });
    area.addEventListener('pointercancel', (event) => this.up(event, false), { capture: true });
  }

  private pointer(event: PointerEvent): Pointer {
    const bounds = this.canvas.getBoundingClientRect();
    const px = new Vector2(event.clientX - bounds.left, event.clientY - bounds.top);
    return { px, ray: this.stage.rayAt(px) };
  }

  private down(event: PointerEvent): void {
    if (event.target !== this.canvas || this.isHandingOver) return;
    // Gives the keyboard to the tool, instead of the button that was pressed before.
    this.canvas.focus({ preventScroll: true });
    this.beforePress();
    if (this.pressed) {
      this.pressed.isTap = false;
      if (this.pressed.isTaken) this.handOver();
      return;
    }
    if (event.button !== 0) return;
    const pointer = this.pointer(event);
    const isTaken = this.tool().press(pointer);
    this.pressed = { id: event.pointerId, start: pointer.px, last: event, isTaken, isTap: !isTaken };
    if (isTaken) {
      event.stopPropagation();
      this.canvas.setPointerCapture(event.pointerId);
    }
  }

  private move(event: PointerEvent): void {
    if (!this.pressed || event.pointerId !== this.pressed.id) return;
    const pointer = this.pointer(event);
    if (pointer.px.distanceTo(this.pressed.start) > kTapReachPx) this.pressed.isTap = false;
    this.pressed.last = event;
    if (!this.pressed.isTaken) return;
    event.stopPropagation();
    this.tool().drag(pointer);
  }

  // Ends the tool's gesture at a second finger, because two fingers move the view. The first press is repeated for the
  // view, which has not seen it.
  private handOver(): void {
    const pressed = this.pressed!;
    pressed.isTaken = false;
    this.tool().abandon();
    const { pointerId, pointerType, clientX, clientY, isPrimary } = pressed.last;
    this.isHandingOver = true;
    const down = { pointerId, pointerType, clientX, clientY, isPrimary, button: 0, buttons: 1, bubbles: true };
    this.canvas.dispatchEvent(new PointerEvent('pointerdown', down));
    this.isHandingOver = false;
  }

  private up(event: PointerEvent, isTapAllowed: boolean): void {
    if (!this.pressed || event.pointerId !== this.pressed.id) return;
    const { isTaken, isTap } = this.pressed;
    this.pressed = undefined;
    if (isTaken) {
      event.stopPropagation();
      this.tool().release();
    } else if (isTap && isTapAllowed) {
      this.tool().tap(this.pointer(event));
    }
  }
}
