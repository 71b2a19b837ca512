import type { Point2 } from '../geometry/locator';
import type { Pointer, Tool, Viewer } from './tool';

/** Takes one tap on the sheet, as a point of the material. */
export class PickTool implements Tool {
  readonly id = 'pick';
  readonly cursor = 'crosshair';
  private picked: ((point: Point2) => void) | undefined;

  /** @param done  called after a point was picked, to choose the tool before */
  constructor(
    private readonly viewer: Pick<Viewer, 'shown'>,
    private readonly done: () => void,
  ) {}

  /** @param picked  gets the point */
  ask(picked: (point: Point2) => void): void {
    this.picked = picked;
  }

  enter(): void {}

  leave(): void {
    this.picked = undefined;
  }

  press(): boolean {
    return false;
  }

  drag(): void {}
  release(): void {}
  abandon(): void {}
  update(): void {}

  tap({ ray }: Pointer): void {
    const material = this.viewer.shown.surface?.pick(ray)?.material;
    const { picked } = this;
    if (!material || !picked) return;
    this.done();
    picked(material);
  }
}
