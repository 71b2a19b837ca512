import type { Ray } from 'three';
import { beforeEach, describe, expect, it } from 'vitest';
import { ChosenPiece } from '../src/tools/chosen_piece';
import type { Viewer } from '../src/tools/tool';

describe('ChosenPiece', () => {
  const kMark = { x: 0.25, y: 0.5 };
  const ray = {} as Ray;
  let hit: { material: typeof kMark } | undefined;
  let place: { slot: number } | undefined;
  let pieces: number[];
  let piece: ChosenPiece;

  beforeEach(() => {
    hit = { material: kMark };
    place = { slot: 1 };
    pieces = [0, 4];
    const surface = {
      pick: () => hit,
      locator: { find: () => place },
      get mirror() {
        return { pieces };
      },
    };
    piece = new ChosenPiece({ shown: { surface } } as unknown as Viewer);
  });

  it('is the piece that was tapped, whatever its label becomes', () => {
    piece.toggle();
    expect([piece.isChoosing, piece.isChosen]).toEqual([true, false]);
    piece.take(ray);
    expect([piece.isChoosing, piece.isChosen, piece.label, piece.place]).toEqual([false, true, 4, kMark]);
    pieces = [0, 2];
    expect(piece.label).toBe(2);
  });

  it('is still chosen, without a label, once its material is gone', () => {
    piece.take(ray);
    place = undefined;
    expect([piece.isChosen, piece.label, piece.place]).toEqual([true, undefined, undefined]);
  });

  it('is still to be chosen after a tap beside the sheet', () => {
    hit = undefined;
    piece.toggle();
    piece.take(ray);
    expect([piece.isChoosing, piece.isChosen]).toEqual([true, false]);
    piece.toggle();
    expect(piece.isChoosing).toBe(false);
  });

  it('is forgotten where another is to be chosen', () => {
    piece.take(ray);
    piece.toggle();
    expect([piece.isChoosing, piece.isChosen]).toEqual([false, false]);
  });
});
