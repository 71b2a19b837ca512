import { element } from './dom';

/** Part of the window along one side, CSS pixels. */
interface Span {
  first: number;
  last: number;
}

/** Says if the window is that of a phone, upright and across; as in style/phone.css and low_window.css. */
const kAcross = '(max-height: 479px) and (min-width: 641px)';
const kUpright = '(max-width: 640px), (max-width: 760px) and (min-height: 480px)';
// Elements that cover the lower part of an upright phone's window while they are shown, or the right part across.
const kCovers = '#cut-panel, #measure-panel, .side-panel, #replay';
const kCoversAcross = '#cut-panel, #measure-panel, .side-panel';

/**
 * Returns by how many CSS pixels to move the picture up, or left, so that its middle is in the middle of what panels leave.
 * @param size   height or width of the window
 * @param free   part of the window without panels at rest
 * @param cover  top, or left side, of the first panel there; undefined: none is open
 */
export function shiftFor(size: number, free: Span, cover: number | undefined): number {
  if (cover === undefined || cover >= free.last) return 0;
  const middle = 0.5 * (free.first + Math.max(free.first, cover));
  return Math.max(0, Math.round(0.5 * size - middle));
}

function box(id: string): DOMRect {
  return element(id).getBoundingClientRect();
}

// Returns the first top or left side of the elements that are shown.
function firstOf(selector: string, side: 'top' | 'left'): number | undefined {
  const open = [...document.querySelectorAll<HTMLElement>(selector)].filter((panel) => !panel.hidden);
  return open.length === 0 ? undefined : Math.min(...open.map((panel) => panel.getBoundingClientRect()[side]));
}

/** Moves the picture up or left on a phone while a panel covers a part of it. */
export class RoomForSheet {
  private readonly isUpright = matchMedia(kUpright);
  private readonly isAcross = matchMedia(kAcross);

  /**
   * @param stage      takes the shift, CSS pixels
   * @param isDrawing  true while a drawing lies on the picture, which would not move with it
   */
  constructor(
    private readonly stage: { shift(leftPx: number, upPx: number): void },
    private readonly isDrawing: () => boolean,
  ) {
    addEventListener('resize', () => this.update());
  }

  /** Call it when a panel was opened or closed. */
  update(): void {
    if (this.isDrawing()) return;
    const [left, up] = [this.isAcross.matches ? this.left : 0, this.isUpright.matches ? this.up : 0];
    this.stage.shift(left, up);
    element('picture').style.transform = left > 0 || up > 0 ? `translate(${-left}px, ${-up}px)` : '';
  }

  private get up(): number {
    return shiftFor(innerHeight, { first: box('status').bottom, last: box('controls').top }, firstOf(kCovers, 'top'));
  }

  private get left(): number {
    return shiftFor(innerWidth, { first: box('tools').right, last: box('panel-bar').left }, firstOf(kCoversAcross, 'left'));
  }
}
