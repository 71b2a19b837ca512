import { beforeEach, describe, expect, it, vi } from 'vitest';
import { SheetLook } from '../src/ui/sheet_look';
import type { LookedAt } from '../src/ui/sheet_look';
import { fakePage } from './support/fake_page';
import type { FakeElement } from './support/fake_page';

describe('SheetLook of a recording', () => {
  let byId: (id: string) => FakeElement;
  let look: SheetLook;
  let notices: string[];
  let isPictureShown: boolean;
  let mirror: { topologyVersion: number; numPieces: number; strains: Float32Array | undefined };
  const view = { colorByPiece: vi.fn(), colorByStrain: vi.fn() };
  /** label -> id, as what is there now was coloured. */
  const colored = (): ReadonlyMap<number, number> => {
    look.color();
    return view.colorByPiece.mock.lastCall![0];
  };

  beforeEach(() => {
    byId = fakePage();
    notices = [];
    mirror = { topologyVersion: 0, numPieces: 2, strains: undefined };
    isPictureShown = false;
    view.colorByPiece.mockReset();
    view.colorByStrain.mockReset();
    const parts = {
      view,
      shown: { surface: { mirror }, showAgain: () => {} },
      live: { sheetName: '', isWatched: false, restart: () => {} },
      notices: { notify: (_: string, text: string) => void notices.push(text) },
      isPictureShown: () => isPictureShown,
    };
    look = new SheetLook(parts as unknown as LookedAt);
  });

  it('colours pieces by ids, which are 1 and more', () => {
    look.toggleByPiece();
    expect([...colored()]).toEqual([
      [0, 1],
      [1, 2],
    ]);
  });

  it('colours anew in each topology version, though the number of pieces stays', () => {
    look.toggleByPiece();
    const before = colored();
    expect(colored()).toBe(before);
    mirror.topologyVersion = 1;
    expect(colored()).not.toBe(before);
    // Another recording, or another connection in the same one.
    const after = colored();
    look.reset();
    expect(colored()).not.toBe(after);
  });

  it('says where no strains were recorded, and shows the cloth as it is there', () => {
    look.toggleByStrain();
    expect(notices).toEqual(['No strains were recorded here: colouring by strain was off at that time']);
    expect(colored()).toBe(null);
    expect([byId('strain-scale').hidden, byId('strain-missing').hidden]).toEqual([true, false]);
    mirror.strains = Float32Array.of(0.1);
    view.colorByStrain.mockReturnValue(0.2);
    look.color();
    expect([byId('strain-scale').hidden, byId('strain-missing').hidden]).toEqual([false, true]);
    const ticks = () => byId('strain-ticks').options.map((tick) => (tick as FakeElement).textContent);
    expect(ticks()).toEqual(['−20', '−10', '0', '10', '20 %']);
    // Pictures of the server come with a scale of their own.
    isPictureShown = true;
    look.strainScale.show(0.005);
    look.color();
    expect(ticks().at(-1)).toBe('0.5 %');
  });
});
