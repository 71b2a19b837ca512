import { describe, expect, it } from 'vitest';
import { borderOf, kMaxHoles } from '../src/geometry/nesting';

// A square around (x, y), from its lower left corner, either way round.
function square(x: number, y: number, half: number, isClockwise = false) {
  const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([u, v]) => ({ x: x + u * half, y: y + v * half }));
  return isClockwise ? corners.reverse() : corners;
}

describe('borderOf', () => {
  it('takes the line around the largest area, wherever it stands and whichever way it runs', () => {
    const holes = [square(2, 2, 1), square(7, 7, 2, true), square(2, 8, 1)];
    expect(borderOf([square(5, 5, 5), ...holes])).toBe(0);
    expect(borderOf([...holes, square(5, 5, 5, true)])).toBe(3);
    expect(borderOf([square(5, 5, 5)])).toBe(0);
  });

  it('takes holes in the bays of a border for what they are', () => {
    const u = [[0, 0], [9, 0], [9, 9], [6, 9], [6, 3], [3, 3], [3, 9], [0, 9]].map(([x, y]) => ({ x, y }));
    expect(borderOf([u, square(1.5, 6, 1), square(7.5, 6, 1)])).toBe(0);
    expect(() => borderOf([u, square(4.5, 6, 1)])).toThrow('outside of its largest one');
  });

  it('leaves lines that touch or cross the border to the server', () => {
    expect(borderOf([square(5, 5, 5), square(1, 5, 1)])).toBe(0);
    expect(borderOf([square(5, 5, 5), [...square(1, 5, 1.2), { x: 0.5, y: 5 }]])).toBe(0);
  });

  it('refuses what lies outside, and what lies in a hole, and says what to do', () => {
    const border = square(5, 5, 5);
    expect(() => borderOf([border, square(20, 5, 1)])).toThrow(/outside .*move them into it, or remove them/);
    // Two sheets of one size.
    expect(() => borderOf([border, square(20, 5, 5)])).toThrow('outside');
    expect(() => borderOf([square(5, 5, 1), border, square(5, 5, 3)])).toThrow(/inside a hole.*remove the inner ones/);
  });

  it('takes as many holes as there may be, and not one more', () => {
    const holes = Array.from({ length: kMaxHoles }, (_, i) => square(i % 32, Math.floor(i / 32), 0.3));
    expect(borderOf([...holes, square(16, 16, 20)])).toBe(kMaxHoles);
    const more = [...holes, square(-2, -2, 0.3), square(16, 16, 20)];
    expect(() => borderOf(more)).toThrow('has 1,025 lines besides its border, but a sheet has at most 1,024 holes');
  });
});
