import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { MaterialSchema } from '../src/gen/kerf/v1/scene_pb';
import { bendingStiffness } from '../src/ui/material_text';
import { kMaterialQuantities, materialRefusal } from '../src/ui/physics/material_quantities';
import { linearScale, logScale } from '../src/ui/physics/slider_scale';

const kCotton = create(MaterialSchema, {
  youngsModulusPa: 4e7,
  youngsModulus2Pa: 3e7,
  poissonsRatio: 0.25,
  shearModulusPa: 1.5e5,
  directionRad: 0.5,
  thicknessM: 4e-4,
  densityKgpm3: 375,
  bendingScale: 0.04,
  massDampingPerS: 0.1,
  stiffnessDampingS: 1e-5,
});
const kMeasured = { ...kCotton, bendingStiffness1Nm: 9e-6, bendingStiffness2Nm: 6e-6, bendingCouplingNm: -1e-6 };

const quantity = (id: string) => kMaterialQuantities.find((each) => each.id === id)!;

describe('refusals of a material', () => {
  it('name its numbers as the panel does', () => {
    expect(materialRefusal('set_material.material.thickness_m is 2; choose a value from 1e-6 to 0.1')).toBe(
      'Thickness is 2; choose a value from 1e-6 to 0.1',
    );
    expect(materialRefusal('the law must be positive definite')).toBe('the law must be positive definite');
  });
});

describe('scales of sliders', () => {
  it('go up in equal steps, to values that can be read', () => {
    const scale = linearScale(-0.5, 0.9, 0.01);
    expect([scale.valueAt(0), scale.valueAt(80), scale.valueAt(scale.end)]).toEqual([-0.5, 0.3, 0.9]);
  });

  it('go up in equal factors, with zero at the left where that means something', () => {
    const scale = logScale(0.01, 100, true);
    expect([0, 1, 41, scale.end].map((place) => scale.valueAt(place))).toEqual([0, 0.01, 0.1, 100]);
    expect([0, 1e-9, 0.01, 0.1, 1e9].map((value) => scale.placeOf(value))).toEqual([0, 1, 1, 41, scale.end]);
    expect(logScale(1, 10).placeOf(0)).toBe(0);
  });

  it('keep the place of each of their values', () => {
    for (const { scale } of kMaterialQuantities) {
      for (let place = 0; place <= scale.end; ++place) expect(scale.placeOf(scale.valueAt(place))).toBe(place);
    }
  });
});

describe('numbers of a material', () => {
  it.each(kMaterialQuantities)('$name is read as it was written', ({ read, write, scale }) => {
    for (const place of [0, 1, Math.round(scale.end / 3), scale.end]) {
      const value = scale.valueAt(place);
      for (const material of [kCotton, kMeasured]) {
        expect(read(write(material, value))).toBeCloseTo(value, 12 - Math.log10(Math.abs(value) + 1e-12));
      }
    }
  });

  it('stiffness is that of all of the membrane, across and shear alone', () => {
    const stiffer = quantity('stiffness').write(kCotton, 8e7);
    expect(stiffer).toEqual({ ...kCotton, youngsModulusPa: 8e7, youngsModulus2Pa: 6e7, shearModulusPa: 3e5 });
    expect(quantity('shear').write(kCotton, 1e6)).toEqual({ ...kCotton, shearModulusPa: 1e6 });
  });

  it('bending is scaled whole, so that it stays a law that can be', () => {
    const { write } = quantity('bending');
    const stiffer = write(kMeasured, 1.8e-5);
    expect(stiffer.bendingStiffness2Nm).toBeCloseTo(1.2e-5, 15);
    expect(stiffer.bendingCouplingNm).toBeCloseTo(-2e-6, 15);
    expect(stiffer.bendingScale).toBeCloseTo(0.08, 12);
    expect(stiffer.thicknessM).toBe(kMeasured.thicknessM);
  });

  it('bending can be none, and come back', () => {
    const { write } = quantity('bending');
    for (const material of [kCotton, kMeasured]) {
      const limp = write(material, 0);
      expect([bendingStiffness(limp), limp.bendingStiffness1Nm]).toEqual([0, undefined]);
      expect(bendingStiffness(write(limp, 2e-6))).toBeCloseTo(2e-6, 15);
    }
  });
});
