import { describe, expect, it } from 'vitest';
import { shiftFor } from '../src/ui/room_for_sheet';

describe('shiftFor', () => {
  const free = { first: 100, last: 700 };

  it('puts the middle of the picture into the middle of what a panel leaves', () => {
    expect(shiftFor(844, free, 400)).toBe(844 / 2 - 250);
  });

  it('is none without a panel, and where it covers nothing more', () => {
    expect([shiftFor(844, free, undefined), shiftFor(844, free, 720)]).toEqual([0, 0]);
  });

  it('never moves the picture down, or beyond a panel that covers all', () => {
    expect(shiftFor(844, { first: 400, last: 800 }, 600)).toBe(0);
    expect(shiftFor(844, free, 20)).toBe(322);
  });
});
