import { Vector3 } from 'three';
import { beforeEach, describe, expect, it } from 'vitest';
import { Newest } from '../src/newest';
import { springLook } from '../src/tools/spring_look';
import { windSetting, windVelocity } from '../src/ui/physics/wind_control';

describe('wind', () => {
  const kBefore = { azimuthDeg: 70, risingDeg: 10, speedMps: 4 };

  it('blows from x to y, and up', () => {
    const along = (azimuthDeg: number, risingDeg: number) =>
      new Vector3().copy(windVelocity({ azimuthDeg, risingDeg, speedMps: 2 }));
    expect(along(0, 0).distanceTo(new Vector3(2, 0, 0))).toBeLessThan(1e-12);
    expect(along(90, 0).distanceTo(new Vector3(0, 2, 0))).toBeLessThan(1e-12);
    expect(along(30, 90).distanceTo(new Vector3(0, 0, 2))).toBeLessThan(1e-12);
  });

  it('is read back as it was set', () => {
    for (const azimuthDeg of [0, 45, 200, 355]) {
      for (const risingDeg of [-60, 0, 35]) {
        const read = windSetting(windVelocity({ azimuthDeg, risingDeg, speedMps: 7 }), kBefore);
        expect(read.azimuthDeg).toBeCloseTo(azimuthDeg, 9);
        expect(read.risingDeg).toBeCloseTo(risingDeg, 9);
        expect(read.speedMps).toBeCloseTo(7, 9);
      }
    }
  });

  it('keeps its direction while it does not blow', () => {
    expect(windSetting({ x: 0, y: 0, z: 0 }, kBefore)).toEqual({ ...kBefore, speedMps: 0 });
  });
});

describe('springLook', () => {
  it('is the thicker and the redder the longer the spring, up to an end', () => {
    const looks = [0, 0.1, 0.2, 0.3, 5].map((lengthM) => springLook(lengthM, 1));
    for (let i = 1; i < 4; ++i) {
      expect(looks[i].widthPx).toBeGreaterThan(looks[i - 1].widthPx);
      expect(looks[i].color.g).toBeLessThan(looks[i - 1].color.g);
    }
    expect(looks[4]).toEqual(looks[3]);
  });

  it('goes by the size of the sheet', () => {
    expect(springLook(1, 8)).toEqual(springLook(0.125, 1));
  });
});

describe('Newest', () => {
  let sent: string[];
  let answer: () => Promise<unknown>;
  let numDone: number;
  let newest: Newest<number>;

  beforeEach(() => {
    sent = [];
    numDone = 0;
    newest = new Newest<number>(
      (name, value) => {
        sent.push(`${name} ${value}`);
        return new Promise<void>((resolve) => {
          answer = () => {
            resolve();
            return new Promise((settled) => setTimeout(settled));
          };
        });
      },
      async () => (numDone += 1),
    );
  });

  it('sends one value at a time, leaves out those that are old by then, and tells when it is done', async () => {
    for (const value of [1, 2, 3]) newest.put('a', value);
    expect([sent, newest.isBusy]).toEqual([['a 1'], true]);
    await answer();
    expect([sent, numDone]).toEqual([['a 1', 'a 3'], 0]);
    await answer();
    expect([sent, newest.isBusy, numDone]).toEqual([['a 1', 'a 3'], false, 1]);
  });

  it('keeps what waits for one sheet while there is something for another', async () => {
    newest.put('a', 1);
    newest.put('a', 2);
    newest.put('b', 3);
    await answer();
    newest.put('a', 4);
    newest.put('b', 5);
    for (let left = 3; left > 0; --left) await answer();
    expect(sent).toEqual(['a 1', 'a 2', 'b 5', 'a 4']);
    expect(numDone).toBe(1);
  });
});
