import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { RegionSchema } from '../src/gen/kerf/v1/conditions_pb';
import { MaterialSchema } from '../src/gen/kerf/v1/scene_pb';
import { bendingStiffness, materialFacts, partName, presetOf } from '../src/ui/material_text';

const kSilk = create(MaterialSchema, {
  youngsModulusPa: 8e7,
  youngsModulus2Pa: 6e7,
  poissonsRatio: 0.2,
  shearModulusPa: 2e5,
  thicknessM: 1.2e-4,
  densityKgpm3: 420,
  bendingScale: 0.15,
  massDampingPerS: 0.1,
  stiffnessDampingS: 1e-5,
});

describe('bendingStiffness', () => {
  it('is that of a plate, scaled: of silk the 1.8e-6 N m that it is said to have', () => {
    expect(bendingStiffness(kSilk)).toBeCloseTo(1.78e-6, 8);
  });

  it('is the one that is given', () => {
    expect(bendingStiffness({ ...kSilk, bendingStiffness1Nm: 3e-5 })).toBe(3e-5);
  });
});

describe('materialFacts', () => {
  it('tells both directions where they differ, and the mass of an area', () => {
    const facts = Object.fromEntries(materialFacts(kSilk));
    expect(facts.Stiffness).toBe('80 MPa along, 60 MPa across');
    expect(facts.Mass).toBe('50.4 g/m²');
    expect(facts.Damping).toBe('0.1 /s, 10 µs');
  });
});

describe('presetOf', () => {
  const presets = [{ ...kSilk, densityKgpm3: 400, preset: 'other' }, { ...kSilk, preset: 'silk' }];

  it('goes by the numbers, whichever way the fibres run', () => {
    expect(presetOf(kSilk, presets)).toBe('silk');
    expect(presetOf({ ...kSilk, directionRad: 1 }, presets)).toBe('silk');
    expect(presetOf({ ...kSilk, thicknessM: 1.3e-4 }, presets)).toBe('');
    expect(presetOf({ ...kSilk, bendingStiffness1Nm: 1e-6 }, presets)).toBe('');
  });
});

describe('partName', () => {
  it('is a number, with the component where there is one; a whole component has its own name', () => {
    const nearest = { case: 'nearest' as const, value: { x: 0, y: 0 } };
    const all = { case: 'all' as const, value: true };
    expect(partName(undefined, 1)).toBe('part 1');
    expect(partName(create(RegionSchema, { region: all }), 2)).toBe('part 2');
    expect(partName(create(RegionSchema, { region: all, component: 'ribbon' }), 0)).toBe('ribbon');
    expect(partName(create(RegionSchema, { region: nearest, component: 'ribbon' }), 3)).toBe('part 3, of ribbon');
  });
});
