import { Vector2 } from 'three';
import { describe, expect, it } from 'vitest';
import { nearestPlace, spread } from '../src/tools/cut_handles';

const at = (x: number, y: number) => new Vector2(x, y);

describe('spread', () => {
  it('leaves places that are far enough from each other', () => {
    const places = [at(0, 0), undefined, at(30, 0), at(0, 40)];
    expect(spread(places, -1)).toEqual(places);
  });

  it('moves those apart that would overlap, also in one place', () => {
    for (const places of [[at(0, 0), at(22, 0)], [at(5, 5), at(5, 5), at(6, 5)], [at(0, 0), at(10, 0), at(20, 0), at(30, 0)]]) {
      const moved = spread(places, -1) as Vector2[];
      moved.forEach((a, i) => moved.slice(i + 1).forEach((b) => expect(a.distanceTo(b)).toBeGreaterThan(24)));
    }
    // Both move by the same, along the line between them.
    expect(spread([at(0, 0), at(22, 0)], -1)).toEqual([at(-2.5, 0), at(24.5, 0)]);
  });

  it('leaves the one that is held', () => {
    expect(spread([at(0, 0), at(20, 0)], 1)).toEqual([at(-7, 0), at(20, 0)]);
  });
});

describe('nearestPlace', () => {
  it('is that of the nearer of two whose areas overlap', () => {
    const places = [at(0, 0), at(22, 0), undefined];
    expect([nearestPlace(places, at(9, 0)), nearestPlace(places, at(12, 0)), nearestPlace([undefined], at(0, 0))]).toEqual([0, 1, -1]);
  });
});
