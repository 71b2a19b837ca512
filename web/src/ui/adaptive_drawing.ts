import type { App } from '../app';
import { DrawingQuality } from '../scene/drawing_quality';

// Names that browsers have for drawing without a graphics card.
const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** @param graphics  name of what draws, as the browser has it */
export function slowDrawingText(graphics: string): string {
  return `Drawing is slow ${kSoftware.test(graphics) ? 'without a graphics card' : 'in this browser'}.`;
}

/**
 * Draws as finely as this machine can often enough. If even the coarsest pictures come too seldom, it says why, once, and
 * offers those of the server.
 */
export class AdaptiveDrawing {
  private readonly quality = new DrawingQuality();
  private readonly isFixed = new URLSearchParams(location.search).get('resolution') === 'full';
  // The time of the last picture, if it counts.
  private drawnMs: number | undefined;
  private hasOffered = false;
  private closeOffer: (() => void) | undefined;

  constructor(private readonly app: App) {
    // Nothing is drawn while nobody looks: no picture takes that long.
    document.addEventListener('visibilitychange', () => (this.drawnMs = undefined));
  }

  /**
   * Begins the drawing loop's turn at `nowMs`.
   * @param isChanged  what is seen has changed since the last turn
   * @returns whether there is anything to draw
   */
  begin(nowMs: number, isChanged: boolean): boolean {
    const { app, quality } = this;
    if (this.isFixed) return isChanged;
    if (this.drawnMs !== undefined) quality.took(nowMs - this.drawnMs);
    // Little is drawn here over pictures of the server.
    const isOwn = !app.imageMode.isOn;
    this.drawnMs = isChanged && isOwn ? nowMs : undefined;
    if (isChanged) quality.moved(nowMs);
    const isRefined = app.stage.setQuality(quality.at(nowMs, isOwn && app.isMoving));
    if (!isOwn) this.closeOffer?.();
    else if (quality.isTooSlow) this.offer();
    return isChanged || isRefined;
  }

  private offer(): void {
    const { app } = this;
    if (this.hasOffered || !app.watch) return;
    this.hasOffered = true;
    const text = slowDrawingText(app.stage.graphics);
    this.closeOffer = app.notices.offer(text, 'Let the server draw', () => void app.imageMode.toggle());
  }
}
