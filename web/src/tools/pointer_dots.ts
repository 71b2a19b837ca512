import type { Point2 } from '../geometry/locator';
import { pieceColor } from '../scene/piece_colors';
import type { Viewer } from './tool';

/** The number of the dot of this page's user; viewers have numbers from 1 on. */
export const kOwnDot = 0;

// A name is to the left of a dot that is farther right than this share of the canvas, where it has room.
const kTurned = 0.75;

interface Dot {
  readonly item: HTMLElement;
  readonly name: HTMLElement;
  material: Point2;
}

/** Dots with names where viewers point. They stay at their place of the sheet while it moves. */
export class PointerDots {
  private readonly dots = new Map<number, Dot>();

  constructor(private readonly viewer: Pick<Viewer, 'overlay' | 'stage' | 'shown'>) {}

  get isEmpty(): boolean {
    return this.dots.size === 0;
  }

  /**
   * Moves the dot of a viewer.
   * @param name      empty: no name
   * @param material  metres; undefined takes the dot away
   */
  set(viewer: number, name: string, material: Point2 | undefined): void {
    if (!material) return this.remove(viewer);
    const dot = this.dots.get(viewer) ?? this.create(viewer);
    dot.material = material;
    dot.name.hidden = name === '';
    if (dot.name.textContent !== name) dot.name.textContent = name;
    this.viewer.stage.invalidate();
  }

  /** Takes away the dots of viewers who are not among these. That of this page's user stays. */
  keepOnly(viewers: ReadonlySet<number>): void {
    for (const viewer of this.dots.keys()) {
      if (viewer !== kOwnDot && !viewers.has(viewer)) this.remove(viewer);
    }
  }

  clear(): void {
    for (const viewer of this.dots.keys()) this.remove(viewer);
  }

  /** Puts all dots where the sheet is now; one whose place was cut out is hidden. Call it before each drawing. */
  update(): void {
    const { stage, shown } = this.viewer;
    for (const { item, name, material } of this.dots.values()) {
      const world = shown.surface?.onSheet(material);
      const px = world && stage.project(world);
      item.hidden = !px;
      if (!px) continue;
      item.style.transform = `translate(${px.x.toFixed(1)}px, ${px.y.toFixed(1)}px)`;
      name.classList.toggle('turned', px.x > kTurned * stage.sizePx.x);
    }
  }

  private create(viewer: number): Dot {
    const [item, name] = [document.createElement('div'), document.createElement('span')];
    item.className = viewer === kOwnDot ? 'pointer-dot own' : 'pointer-dot';
    item.setAttribute('aria-hidden', 'true');
    if (viewer !== kOwnDot) item.style.setProperty('--dot', `#${pieceColor(viewer).getHexString()}`);
    item.hidden = true;
    item.append(name);
    this.viewer.overlay.append(item);
    const dot = { item, name, material: { x: 0, y: 0 } };
    this.dots.set(viewer, dot);
    return dot;
  }

  private remove(viewer: number): void {
    this.dots.get(viewer)?.item.remove();
    this.dots.delete(viewer);
  }
}
