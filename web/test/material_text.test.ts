import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { MaterialSchema } from '../src/gen/kerf/v1/scene_pb';
import { bendingStiffness, materialFacts, siText } from '../src/ui/material_text';

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

describe('siText', () => {
  it('takes the prefix that reads best', () => {
    expect(siText(1.5e5, 'Pa')).toBe('150 kPa');
    expect(siText(6.9e10, 'Pa')).toBe('69 GPa');
    expect(siText(1.6e-5, 'm')).toBe('16 µm');
    expect(siText(0, 's')).toBe('0 s');
    expect(siText(1e-12, 'N m')).toBe('0.001 nN m');
  });
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
