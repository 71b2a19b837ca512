import type { Material } from '../../gen/kerf/v1/scene_pb';
import { bendingStiffness, plateStiffness } from '../material_text';
import { linearScale, logScale } from './slider_scale';
import type { SliderScale } from './slider_scale';

/**
 * One number of a material that a slider sets. The slider has a useful range; the field beside it takes all that the
 * server accepts.
 */
export interface MaterialQuantity {
  readonly id: string;
  readonly name: string;
  readonly tip: string;
  /** Takes prefixes if isSi. */
  readonly unit: string;
  readonly isSi: boolean;
  readonly scale: SliderScale;
  read(material: Material): number;
  /** Returns the material with this number. */
  write(material: Material, value: number): Material;
}

const kDegree = Math.PI / 180;

function times(value: number | undefined, factor: number): number | undefined {
  return value === undefined ? undefined : factor * value;
}

// Scales all moduli of the membrane by one factor, so that the ratios between directions stay.
function withStiffness(material: Material, youngsModulusPa: number): Material {
  const factor = youngsModulusPa / (material.youngsModulusPa ?? youngsModulusPa);
  const youngsModulus2Pa = times(material.youngsModulus2Pa, factor);
  return { ...material, youngsModulusPa, youngsModulus2Pa, shearModulusPa: times(material.shearModulusPa, factor) };
}

// Scales all bending stiffnesses by one factor. A material without measured ones bends as a plate times bendingScale.
function withBending(material: Material, stiffnessNm: number): Material {
  const before = bendingStiffness(material);
  if (!(before > 0) || stiffnessNm === 0) {
    return {
      ...material,
      bendingScale: stiffnessNm / plateStiffness(material),
      bendingStiffness1Nm: undefined,
      bendingStiffness2Nm: undefined,
      bendingCouplingNm: undefined,
      twistingStiffnessNm: undefined,
    };
  }
  const factor = stiffnessNm / before;
  return {
    ...material,
    bendingScale: times(material.bendingScale ?? 1, factor),
    bendingStiffness1Nm: times(material.bendingStiffness1Nm, factor),
    bendingStiffness2Nm: times(material.bendingStiffness2Nm, factor),
    bendingCouplingNm: times(material.bendingCouplingNm, factor),
    twistingStiffnessNm: times(material.twistingStiffnessNm, factor),
  };
}

type NumberField = {
  [K in keyof Material]-?: Material[K] extends number | undefined ? K : never;
}[keyof Material];

function field(name: NumberField): Pick<MaterialQuantity, 'read' | 'write'> {
  return { read: (material) => material[name] ?? 0, write: (material, value) => ({ ...material, [name]: value }) };
}

export const kBendingId = 'bending';

export const kMaterialQuantities: readonly MaterialQuantity[] = [
  {
    id: 'stiffness',
    name: 'Stiffness',
    tip: 'Young’s modulus along the fibres; transverse and shear change by the same factor',
    unit: 'Pa',
    isSi: true,
    scale: logScale(1e3, 1e11),
    read: ({ youngsModulusPa = 0 }) => youngsModulusPa,
    write: withStiffness,
  },
  {
    id: 'across',
    name: 'Transverse',
    tip: 'Young’s modulus across the fibres',
    unit: 'Pa',
    isSi: true,
    scale: logScale(1e3, 1e11),
    ...field('youngsModulus2Pa'),
  },
  {
    id: 'shear',
    name: 'Shear',
    tip: 'Shear modulus',
    unit: 'Pa',
    isSi: true,
    scale: logScale(1e3, 1e11),
    ...field('shearModulusPa'),
  },
  {
    id: 'poisson',
    name: 'Poisson’s ratio',
    tip: 'How much the sheet narrows as it is stretched along the fibres',
    unit: '',
    isSi: false,
    scale: linearScale(-0.5, 0.9, 0.01),
    ...field('poissonsRatio'),
  },
  {
    id: 'direction',
    name: 'Direction',
    tip: 'Direction of the fibres, from the sheet’s x to its y axis; presets keep it',
    unit: '°',
    isSi: false,
    scale: linearScale(-180, 180, 5),
    read: ({ directionRad = 0 }) => directionRad / kDegree,
    write: (material, degrees) => ({ ...material, directionRad: degrees * kDegree }),
  },
  {
    id: kBendingId,
    name: 'Bending',
    tip: 'Bending stiffness along the fibres; transverse and twisting change by the same factor. A plate’s follows from stiffness and thickness',
    unit: 'N m',
    isSi: true,
    scale: logScale(1e-8, 1e-1, true),
    read: bendingStiffness,
    write: withBending,
  },
  {
    id: 'thickness',
    name: 'Thickness',
    tip: 'Mass, stretching and bending grow with it',
    unit: 'm',
    isSi: true,
    scale: logScale(1e-5, 1e-2),
    ...field('thicknessM'),
  },
  {
    id: 'density',
    name: 'Density',
    tip: 'Mass per volume',
    unit: 'kg/m³',
    isSi: false,
    scale: logScale(10, 1e4),
    ...field('densityKgpm3'),
  },
  {
    id: 'drag',
    name: 'Damping',
    tip: 'Rayleigh’s alpha: slows all motion',
    unit: '/s',
    isSi: false,
    scale: logScale(0.01, 100, true),
    ...field('massDampingPerS'),
  },
  {
    id: 'friction',
    name: 'Stretch damping',
    tip: 'Rayleigh’s beta: slows stretching, in proportion to stiffness',
    unit: 's',
    isSi: true,
    scale: logScale(1e-7, 0.1, true),
    ...field('stiffnessDampingS'),
  },
  {
    id: 'strain-limit',
    name: 'Strain limit',
    tip: 'Strain that the material bears; it does not change the motion. Statistics shows the share of the sheet beyond it',
    unit: '%',
    isSi: false,
    scale: logScale(0.1, 100),
    read: ({ strainLimit = 0 }) => 100 * strainLimit,
    write: (material, percent) => ({ ...material, strainLimit: percent / 100 }),
  },
];

// Labels of the fields of kerf.v1.Material.
const kFieldNames: Record<string, string> = {
  youngs_modulus_pa: 'Stiffness',
  youngs_modulus_2_pa: 'Transverse stiffness',
  shear_modulus_pa: 'Shear stiffness',
  poissons_ratio: 'Poisson’s ratio',
  direction_rad: 'Direction',
  thickness_m: 'Thickness',
  density_kgpm3: 'Density',
  bending_scale: 'Bending',
  mass_damping_per_s: 'Damping',
  stiffness_damping_s: 'Stretch damping',
};

/** Replaces field names in the server's message about a material by the names shown here. */
export function materialRefusal(text: string): string {
  return text.replaceAll(/(?:set_material\.)?material\.(\w+)/g, (_, name: string) => kFieldNames[name] ?? name);
}
