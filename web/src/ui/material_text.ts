import type { Material } from '../gen/kerf/v1/scene_pb';

/** A number to three digits with a prefix of its unit: 1.5e5 Pa is "150 kPa". */
export function siText(value: number, unit: string): string {
  const prefixes: [number, string][] = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];
  if (value === 0) return `0 ${unit}`;
  const [factor, prefix] = prefixes.find(([scale]) => Math.abs(value) >= scale * 0.9995) ?? prefixes.at(-1)!;
  return `${Number((value / factor).toPrecision(3)).toLocaleString('en')} ${prefix}${unit}`;
}

/** Bending stiffness along the first axis, N m, given or that of the plate that the other numbers make (kerf.v1.Material). */
export function bendingStiffness(material: Material): number {
  const { youngsModulusPa: e1 = 0, youngsModulus2Pa: e2 = e1, poissonsRatio: nu = 0, thicknessM: t = 0 } = material;
  const plate = (e1 * t ** 3) / (12 * (1 - (nu * nu * e2) / e1));
  return material.bendingStiffness1Nm ?? (material.bendingScale ?? 1) * plate;
}

/** What people know a cloth by, in the order in which it is shown. */
export function materialFacts(material: Material): [name: string, value: string][] {
  const { youngsModulusPa: e1 = 0, youngsModulus2Pa: e2 = e1, thicknessM = 0, densityKgpm3 = 0 } = material;
  const stiffness = e1 === e2 ? siText(e1, 'Pa') : `${siText(e1, 'Pa')} along, ${siText(e2, 'Pa')} across`;
  const { massDampingPerS = 0, stiffnessDampingS = 0 } = material;
  return [
    ['Stiffness', stiffness],
    ['Shear', siText(material.shearModulusPa ?? 0, 'Pa')],
    ['Bending', siText(bendingStiffness(material), 'N m')],
    ['Thickness', siText(thicknessM, 'm')],
    ['Mass', `${Number((1e3 * densityKgpm3 * thicknessM).toPrecision(3)).toLocaleString('en')} g/m²`],
    ['Damping', `${massDampingPerS} /s, ${siText(stiffnessDampingS, 's')}`],
  ];
}
