import { DrawingQuality } from '../scene/drawing_quality';
import type { Stage } from '../scene/stage';

/** The parts of the viewer that this file needs. */
export interface AdaptedParts {
  readonly stage: Pick<Stage, 'graphics' | 'setQuality'>;
  readonly live: { readonly isWatched: boolean };
  /** Pictures of the server. */
  readonly imageMode: { readonly isOn: boolean; toggle(): Promise<void> };
  readonly notices: { offer(text: string, label: string, accept: () => void): () => void };
}

// Matches the names by which browsers report drawing without a graphics card.
const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** @param graphics  see Stage.graphics */
export function slowDrawingText(graphics: string): string {
  return `Drawing is slow ${kSoftware.test(graphics) ? 'without a graphics card' : 'in this browser'}.`;
}

/**
 * Draws as finely as this machine can at a good rate. If even the coarsest level is too slow, it says why, once, and
 * offers pictures drawn by the server.
 */
export class AdaptiveDrawing {
  private readonly quality = new DrawingQuality();
  private readonly isFixed = new URLSearchParams(location.search).get('resolution') === 'full';
  // Time of the last picture; undefined if its duration must not count.
  private drawnMs: number | undefined;
  private hasOffered = false;
  private closeOffer: (() => void) | undefined;

  constructor(private readonly parts: AdaptedParts) {
    // A hidden page draws nothing, so that time must not count for a picture.
    document.addEventListener('visibilitychange', () => (this.drawnMs = undefined));
  }

  /**
   * Call it at the beginning of each turn of the drawing loop, at `nowMs`.
   * @param isChanged  true if the view has changed since the last turn
   * @param isMoving   true if the sheet moves by itself
   * @returns true if there is anything to draw
   */
  begin(nowMs: number, isChanged: boolean, isMoving: boolean): boolean {
    const { quality } = this;
    const { imageMode, stage } = this.parts;
    if (this.isFixed) return isChanged;
    if (this.drawnMs !== undefined) quality.took(nowMs - this.drawnMs);
    // Over pictures of the server the page draws little, so its times do not count.
    const isOwn = !imageMode.isOn;
    this.drawnMs = isChanged && isOwn ? nowMs : undefined;
    if (isChanged) quality.moved(nowMs);
    const isRefined = stage.setQuality(quality.at(nowMs, isOwn && isMoving));
    if (!isOwn) this.closeOffer?.();
    else if (quality.isTooSlow) this.offer();
    return isChanged || isRefined;
  }

  private offer(): void {
    const { imageMode, live, notices, stage } = this.parts;
    if (this.hasOffered || !live.isWatched) return;
    this.hasOffered = true;
    const text = slowDrawingText(stage.graphics);
    this.closeOffer = notices.offer(text, 'Let the server draw', () => void imageMode.toggle());
  }
}
