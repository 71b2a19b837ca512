import type { App } from '../app';
import { DrawingQuality } from '../scene/drawing_quality';

// What browsers call drawing without a graphics card.
const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** @param graphics  name of what draws, as the browser has it */
export function slowDrawingText(graphics: string): string {
  return kSoftware.test(graphics)
    ? 'This browser draws without a graphics card, which is slow.'
    : 'This browser draws slowly.';
}

/**
 * Draws as finely as this machine can often enough. Where even the coarsest pictures come too seldom it says why, once, and
 * offers those of the server.
 */
export class AdaptiveDrawing {
  private readonly quality = new DrawingQuality();
  private readonly isFixed = new URLSearchParams(location.search).get('resolution') === 'full';
  // When the last picture was drawn, of those that count.
  private drawnMs: number | undefined;
  private hasOffered = false;
  private closeOffer: (() => void) | undefined;

  constructor(private readonly app: App) {
    // While nobody looks nothing is drawn, and no picture takes that long.
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
    // Over pictures of the server little is drawn here.
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
