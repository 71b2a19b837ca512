import { element } from './dom';

/** Part of the window, CSS pixels. */
interface Span {
  top: number;
  bottom: number;
}

/** Says if the window is as narrow as that of a phone; as in style/phone.css. */
const kPhone = '(max-width: 640px), (max-width: 760px) and (min-height: 480px)';
// Elements that cover the lower part of a phone's window while they are shown.
const kCovers = '#cut-panel, #measure-panel, .side-panel, #replay';

/**
 * Returns by how many CSS pixels the picture is to be moved up, so that its middle is in the middle of what panels leave.
 * @param height  of the window
 * @param free    part of the window without panels at rest
 * @param cover   top of the highest panel at the bottom; undefined: none is open
 */
export function shiftFor(height: number, free: Span, cover: number | undefined): number {
  if (cover === undefined || cover >= free.bottom) return 0;
  const middle = 0.5 * (free.top + Math.max(free.top, cover));
  return Math.max(0, Math.round(0.5 * height - middle));
}

/** Moves the picture up on a phone while a panel covers its lower part. */
export class RoomForSheet {
  private readonly isPhone = matchMedia(kPhone);

  /**
   * @param stage      takes the shift, CSS pixels
   * @param isDrawing  true while a drawing lies on the picture, which would not move with it
   */
  constructor(
    private readonly stage: { shiftUp(px: number): void },
    private readonly isDrawing: () => boolean,
  ) {
    addEventListener('resize', () => this.update());
  }

  /** Call it when a panel was opened or closed. */
  update(): void {
    if (this.isDrawing()) return;
    const shift = this.isPhone.matches ? shiftFor(innerHeight, this.free, this.cover) : 0;
    this.stage.shiftUp(shift);
    element('picture').style.transform = shift > 0 ? `translateY(${-shift}px)` : '';
  }

  private get free(): Span {
    const top = element('status').getBoundingClientRect().bottom;
    return { top, bottom: element('controls').getBoundingClientRect().top };
  }

  private get cover(): number | undefined {
    const open = [...document.querySelectorAll<HTMLElement>(kCovers)].filter((panel) => !panel.hidden);
    return open.length === 0 ? undefined : Math.min(...open.map((panel) => panel.getBoundingClientRect().top));
  }
}
