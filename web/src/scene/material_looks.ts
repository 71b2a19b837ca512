import type { Material } from '../gen/kerf/v1/scene_pb';

/** A pattern in material coordinates, by the number that the shader knows. */
export enum Pattern {
  /** Checks of dyed bands. */
  GINGHAM = 0,
  /** Threads over and under each other. */
  WEAVE = 1,
  /** Diagonal ribs, between which the second colour is seen. */
  TWILL = 2,
  /** Small irregular spots, no threads. */
  GRAIN = 3,
  /** Rows of loops. */
  KNIT = 4,
}

/** The looks of a material. Colours are sRGB. */
export interface MaterialLook {
  readonly pattern: Pattern;
  /** Colours of the side whose triangles are counter-clockwise, and of the other one. */
  readonly front: number;
  readonly back: number;
  readonly second: number;
  /** Strength of the pattern, and of the faint grid that shows stretch and shear, 0..1. */
  readonly contrast: number;
  readonly grid: number;
  /** 0..1, as three.js has it. */
  readonly roughness: number;
  /** Light that grazes the fibres, 0..1. */
  readonly sheen: number;
  /** Share of the light that comes through from the other side, 0..1. */
  readonly translucency: number;
  /** Share of the surroundings that is mirrored, 0..1. */
  readonly mirror: number;
}

interface Anchor {
  readonly modulusPa: number;
  readonly thicknessM: number;
  readonly densityKgpm3: number;
}

const kPlain = { second: 0xffffff, sheen: 0, translucency: 0.1, mirror: 0, roughness: 0.86, grid: 0.14, contrast: 0.1 };

/** Looks of the presets, with the numbers of theirs by which the look of other numbers is chosen. */
export const kLooks: Readonly<Record<string, MaterialLook & Anchor>> = {
  demo: {
    ...kPlain,
    ...{ modulusPa: 4.0e5, thicknessM: 5.0e-4, densityKgpm3: 400 },
    ...{ pattern: Pattern.GINGHAM, front: 0xebe7da, back: 0xf0b48b, translucency: 0 },
  },
  wool: {
    ...kPlain,
    ...{ modulusPa: 3.1e9, thicknessM: 5.0e-4, densityKgpm3: 1300 },
    ...{ pattern: Pattern.KNIT, front: 0x8a7a5c, back: 0x6d624e, contrast: 0.34, roughness: 1, sheen: 0.22, translucency: 0 },
  },
  cotton: {
    ...kPlain,
    ...{ modulusPa: 4.0e7, thicknessM: 4.0e-4, densityKgpm3: 375 },
    ...{ pattern: Pattern.WEAVE, front: 0xb7cbd9, back: 0xdbe3e8, contrast: 0.16, translucency: 0.2 },
  },
  denim: {
    ...kPlain,
    ...{ modulusPa: 5.938e6, thicknessM: 1.066e-3, densityKgpm3: 304 },
    ...{ pattern: Pattern.TWILL, front: 0x2f4a73, back: 0xa9b4c4, second: 0xc9d2de, contrast: 0.3, roughness: 0.95, translucency: 0 },
  },
  silk: {
    ...kPlain,
    ...{ modulusPa: 8.0e7, thicknessM: 1.2e-4, densityKgpm3: 420 },
    ...{ pattern: Pattern.WEAVE, front: 0xb23a5b, back: 0x8e2f52, contrast: 0.04, roughness: 0.34, sheen: 0.5, translucency: 0.25, grid: 0.08 },
  },
  rubber: {
    ...kPlain,
    ...{ modulusPa: 1.5e6, thicknessM: 1.0e-3, densityKgpm3: 950 },
    ...{ pattern: Pattern.GRAIN, front: 0x33373c, back: 0x4a3b36, contrast: 0.05, roughness: 0.42, translucency: 0, grid: -0.35 },
  },
  paper: {
    ...kPlain,
    ...{ modulusPa: 5.5e9, thicknessM: 1.0e-4, densityKgpm3: 800 },
    ...{ pattern: Pattern.GRAIN, front: 0xf7f9ff, back: 0xe2e6ef, contrast: 0.05, roughness: 0.97, translucency: 0.35, grid: 0.16 },
  },
  skin: {
    ...kPlain,
    ...{ modulusPa: 5.0e5, thicknessM: 1.5e-3, densityKgpm3: 1100 },
    ...{ pattern: Pattern.GRAIN, front: 0xe3b7a0, back: 0xb8564d, contrast: 0.1, roughness: 0.55, sheen: 0.12, translucency: 0.3, grid: 0.1 },
  },
  foil: {
    ...kPlain,
    ...{ modulusPa: 6.9e10, thicknessM: 1.6e-5, densityKgpm3: 2710 },
    ...{ pattern: Pattern.GRAIN, front: 0xc6cbd1, back: 0xaab0b8, contrast: 0.03, roughness: 0.25, translucency: 0, mirror: 0.75, grid: 0.1 },
  },
};

/**
 * Returns the name of the look for a material: that of the preset whose stiffness, thickness and density are nearest, by
 * their ratios. So a material keeps its look while its numbers are changed a little.
 */
export function lookName(material: Material | undefined): string {
  const { youngsModulusPa: along, youngsModulus2Pa: across = along, thicknessM, densityKgpm3 } = material ?? {};
  if (!along || !across || !thicknessM || !densityKgpm3) return 'demo';
  const far = (a: number, b: number) => Math.log(a / b) ** 2;
  const distance = ({ modulusPa, thicknessM: t, densityKgpm3: density }: Anchor) =>
    far(Math.max(along, across), modulusPa) + far(thicknessM, t) + far(densityKgpm3, density);
  const names = Object.keys(kLooks);
  return names.reduce((best, name) => (distance(kLooks[name]) < distance(kLooks[best]) ? name : best));
}
