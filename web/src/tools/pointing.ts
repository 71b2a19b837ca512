import { Vector2 } from 'three';
import type { Point2 } from '../geometry/locator';
import type { Viewer } from './tool';

// Least time between two places that are sent: below the 20 a second that the server passes on.
const kLeastMs = 60;

export interface PointingEvents {
  /** Called when pointing was turned on or off. */
  onToggled(isOn: boolean): void;
  /** Called when the place at which the others see this user point has changed; undefined: nowhere. */
  onPointed(material: Point2 | undefined): void;
  /** Returns the place of the cross that keys move, CSS pixels; undefined while there is none. */
  cross(): Vector2 | undefined;
}

/** Shows the others where this user points: the place of the sheet under the mouse, the finger or the cross. */
export class Pointing {
  private px: Vector2 | undefined;
  private isChosen = false;
  // The place that the others see; undefined if they see none.
  private sent: Point2 | undefined;
  private lookedMs = -Infinity;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** @param area  element around the canvas, which covers it exactly */
  constructor(
    area: HTMLElement,
    private readonly viewer: Pick<Viewer, 'stage' | 'shown' | 'live' | 'notices'>,
    private readonly events: PointingEvents,
  ) {
    const at = ({ clientX, clientY }: PointerEvent) => {
      const bounds = area.getBoundingClientRect();
      this.move(new Vector2(clientX - bounds.left, clientY - bounds.top));
    };
    // Captured, because tools keep the events of their gestures to themselves.
    area.addEventListener('pointerdown', at, { capture: true });
    area.addEventListener('pointermove', at, { capture: true });
    area.addEventListener('pointerleave', () => this.move(undefined));
    area.addEventListener('pointercancel', () => this.move(undefined));
  }

  get isOn(): boolean {
    return this.isChosen;
  }

  toggle(): void {
    if (!this.isChosen && this.viewer.live.watch === undefined) {
      this.viewer.notices.notify('info', 'Others see where you point on live sheets only');
      return;
    }
    this.isChosen = !this.isChosen;
    this.events.onToggled(this.isChosen);
    this.plan();
  }

  /** Follows the sheet under a mouse that does not move. Call it before each drawing, and when the page is hidden. */
  update(): void {
    this.plan();
  }

  /** Call it when a connection begins or ends: its viewer points nowhere. */
  begin(): void {
    this.sent = undefined;
    this.events.onPointed(undefined);
  }

  private move(px: Vector2 | undefined): void {
    this.px = px;
    this.plan();
  }

  private plan(): void {
    if (this.timer !== undefined || !(this.isChosen || this.sent)) return;
    const waitMs = Math.max(0, this.lookedMs + kLeastMs - performance.now());
    this.timer = setTimeout(() => {
      this.timer = undefined;
      this.send();
    }, waitMs);
  }

  private send(): void {
    this.lookedMs = performance.now();
    const material = this.isChosen && !document.hidden ? this.pointedAt() : undefined;
    if (material?.x === this.sent?.x && material?.y === this.sent?.y) return;
    if (!this.viewer.live.watch?.send({ case: 'pointer', value: { material } })) return;
    this.sent = material;
    this.events.onPointed(material);
  }

  private pointedAt(): Point2 | undefined {
    const { stage, shown } = this.viewer;
    const px = this.events.cross() ?? this.px;
    return px && shown.surface?.pick(stage.rayAt(px))?.material;
  }
}
