import type { Region } from '../gen/kerf/v1/conditions_pb';
import type { Material } from '../gen/kerf/v1/scene_pb';
import { siText } from './quantity_text';

/**
 * Returns the bending stiffness along the first axis, N m, of a plate with the material's modulus and thickness
 * (kerf.v1.Material).
 */
export function plateStiffness(material: Material): number {
  const { youngsModulusPa: e1 = 0, youngsModulus2Pa: e2 = e1, poissonsRatio: nu = 0, thicknessM: t = 0 } = material;
  return (e1 * t ** 3) / (12 * (1 - (nu * nu * e2) / e1));
}

/** Returns the bending stiffness along the first axis, N m: as given, or else that of the plate times bendingScale. */
export function bendingStiffness(material: Material): number {
  return material.bendingStiffness1Nm ?? (material.bendingScale ?? 1) * plateStiffness(material);
}

/** Returns the mass per area, "200 g/m²", by which people know a cloth. */
export function areaMassText({ densityKgpm3 = 0, thicknessM = 0 }: Material): string {
  return `${Number((1e3 * densityKgpm3 * thicknessM).toPrecision(3)).toLocaleString('en')} g/m²`;
}

/** Returns the numbers of a material, in the order in which they are shown. */
export function materialFacts(material: Material): [name: string, value: string][] {
  const { youngsModulusPa: e1 = 0, youngsModulus2Pa: e2 = e1, thicknessM = 0 } = material;
  const stiffness = e1 === e2 ? siText(e1, 'Pa') : `${siText(e1, 'Pa')} along, ${siText(e2, 'Pa')} across`;
  const { massDampingPerS = 0, stiffnessDampingS = 0 } = material;
  return [
    ['Stiffness', stiffness],
    ['Shear', siText(material.shearModulusPa ?? 0, 'Pa')],
    ['Bending', siText(bendingStiffness(material), 'N m')],
    ['Thickness', siText(thicknessM, 'm')],
    ['Mass', areaMassText(material)],
    ['Damping', `${massDampingPerS} /s, ${siText(stiffnessDampingS, 's')}`],
  ];
}

/** Returns the preset with these numbers, regardless of the direction of the fibres; empty if there is none. */
export function presetOf(material: Material, presets: readonly Material[]): string {
  const numbers = (of: Material) =>
    JSON.stringify([
      [of.youngsModulusPa, of.youngsModulus2Pa, of.poissonsRatio, of.shearModulusPa, of.thicknessM, of.densityKgpm3],
      [of.bendingScale, of.massDampingPerS, of.stiffnessDampingS, of.bendingStiffness1Nm, of.bendingStiffness2Nm],
      [of.bendingCouplingNm, of.twistingStiffnessNm, of.strainLimit],
    ]);
  return presets.find((preset) => numbers(preset) === numbers(material))?.preset ?? '';
}

/** Returns the name of the part of a sheet that has another material: a whole component has its own. */
export function partName(region: Region | undefined, index: number): string {
  if (!region?.component) return `part ${index}`;
  return region.region.case === 'all' ? region.component : `part ${index}, of ${region.component}`;
}
