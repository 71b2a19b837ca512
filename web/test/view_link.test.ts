import { Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { linkedView, viewAddress, withoutView } from '../src/ui/view_link';
import type { LinkedView } from '../src/ui/view_link';

const kPage = 'http://127.0.0.1:8080/?sheet=other&resolution=full#part';
const kView: LinkedView = {
  camera: { eye: new Vector3(1.234567, -2, 0.5), target: new Vector3(0, 1e-3, 0.25) },
  colors: 'strain',
  isWireframe: true,
  hasPictures: true,
};
const kPlain: LinkedView = { camera: undefined, colors: 'cloth', isWireframe: false, hasPictures: false };

describe('viewAddress', () => {
  it('holds the sheet and the view, and nothing of the page’s own address', () => {
    expect(viewAddress(kPage, 'sheets/demo', kView)).toBe(
      'http://127.0.0.1:8080/?sheet=demo&camera=1.2346,-2,0.5,0,0.001,0.25&colors=strain&wireframe=1&pictures=1',
    );
    expect(viewAddress(kPage, 'sheets/demo', kPlain)).toBe('http://127.0.0.1:8080/?sheet=demo');
  });
});

describe('linkedView', () => {
  it('reads what viewAddress has written', () => {
    const read = linkedView(new URL(viewAddress(kPage, 'sheets/demo', kView)).search);
    expect({ ...read, camera: undefined }).toEqual({ ...kView, camera: undefined });
    expect(read.camera!.eye.distanceTo(kView.camera!.eye)).toBeLessThan(1e-4);
    expect(read.camera!.target.toArray()).toEqual([0, 0.001, 0.25]);
  });

  it.each(['', '1,2,3', '1,2,3,4,5,x', '1,2,3,4,5,', '1,2,3,1,2,3', '1,2,3,4,5,Infinity', '1,2,3,4,5,6,7', '1e9,0,0,0,0,0'])(
    'takes no camera from "%s"',
    (camera) => {
      expect(linkedView(`?camera=${camera}&colors=all&wireframe=yes`)).toEqual(kPlain);
    },
  );
});

describe('withoutView', () => {
  it('leaves the other parameters', () => {
    const url = new URL(`${viewAddress(kPage, 'sheets/demo', kView)}&resolution=full`);
    expect(withoutView(url).search).toBe('?sheet=demo&resolution=full');
  });
});
