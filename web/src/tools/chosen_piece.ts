import type { Ray } from 'three';
import type { Point2 } from '../geometry/locator';
import type { Viewer } from './tool';

/** The one piece to cut, if the user has chosen it by a tap. */
export class ChosenPiece {
  /** True while the next tap chooses the piece. */
  isChoosing = false;

  // A material point of the piece: its label may change with each cut.
  private mark: Point2 | undefined;

  constructor(private readonly viewer: Pick<Viewer, 'shown'>) {}

  get isChosen(): boolean {
    return this.mark !== undefined;
  }

  /** Label of the piece; undefined if none is chosen, or if the sheet has no material at the mark any more. */
  get label(): number | undefined {
    const { surface } = this.viewer.shown;
    const place = this.mark && surface?.locator.find(this.mark);
    return place && surface!.mirror.pieces[place.slot];
  }

  /** Material point of the mark; undefined if there is no label. */
  get place(): Point2 | undefined {
    return this.label === undefined ? undefined : this.mark;
  }

  /** Lets the next tap choose a piece; if one is chosen, forgets it instead. */
  toggle(): void {
    this.isChoosing = !this.isChoosing && !this.isChosen;
    this.mark = undefined;
  }

  /** Chooses the piece that the ray hits; if it misses the sheet, the next tap chooses. */
  take(ray: Ray): void {
    this.mark = this.viewer.shown.surface?.pick(ray)?.material;
    this.isChoosing = !this.mark;
  }

  forget(): void {
    this.isChoosing = false;
    this.mark = undefined;
  }
}
