import { create } from '@bufbuild/protobuf';
import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { MaterialSchema } from '../src/gen/kerf/v1/scene_pb';
import { kLooks, lookName, Pattern } from '../src/scene/material_looks';

const kPresets = new URL('../../server/core/fem/element/material_presets.cc', import.meta.url);

/** Name, stiffness, thickness and density of each preset of the server. */
function presets(): [string, number, number, number][] {
  const lines = readFileSync(kPresets, 'utf8').matchAll(/\{"(\w+)", \{([^}]*)\}\}/g);
  return [...lines].map(([, name, numbers]) => {
    const [along, across, , , , thicknessM, densityKgpm3] = numbers.split(',').map(Number);
    return [name, Math.max(along, across), thicknessM, densityKgpm3];
  });
}

describe('looks of materials', () => {
  it('are there for every preset of the server, with its numbers', () => {
    const own = Object.entries(kLooks).map(([name, { modulusPa, thicknessM, densityKgpm3 }]) => [name, modulusPa, thicknessM, densityKgpm3]);
    expect(presets().length).toBeGreaterThan(8);
    expect(own).toEqual(presets());
  });

  it('are those of the server’s pictures', () => {
    const source = readFileSync(new URL('../../server/service/picture/material_look.cc', import.meta.url), 'utf8');
    const lines = [...source.matchAll(/\{"(\w+)", \{([^}]*)\}, ([^}]*)\}/g)];
    const drawn = lines.map(([, name, numbers, rest]) => {
      const [front, back, second, pattern, ...finish] = rest.split(', ');
      return [name, ...numbers.split(',').map(Number), ...[front, back, second].map(Number), pattern.slice(1).toUpperCase(), ...finish.map(Number)];
    });
    const own = Object.entries(kLooks).map(([name, look]) => {
      const { modulusPa, thicknessM, densityKgpm3, front, back, second } = look;
      const { contrast, grid, roughness, sheen, translucency, mirror } = look;
      const finish = [contrast, grid, roughness, sheen, translucency, mirror];
      return [name, modulusPa, thicknessM, densityKgpm3, front, back, second, Pattern[look.pattern], ...finish];
    });
    expect(drawn).toEqual(own);
  });

  it('differ in the colour of the front by more than a shade', () => {
    const rgb = (color: number) => [color >> 16, (color >> 8) & 255, color & 255];
    const looks = Object.values(kLooks);
    looks.forEach((a, i) => {
      for (const b of looks.slice(i + 1)) {
        const apart = Math.hypot(...rgb(a.front).map((value, k) => value - rgb(b.front)[k]));
        expect(apart > 20 || a.pattern !== b.pattern).toBe(true);
      }
    });
  });

  it('are those of the nearest preset', () => {
    const material = (youngsModulusPa: number, thicknessM: number, densityKgpm3: number) =>
      lookName(create(MaterialSchema, { youngsModulusPa, thicknessM, densityKgpm3 }));
    for (const [name, ...numbers] of presets()) expect(material(...numbers)).toBe(name);
    expect(material(1.5e5, 5e-4, 400)).toBe('demo');
    expect(material(1.6e8, 1e-4, 400)).toBe('silk');
    expect(lookName(undefined)).toBe('demo');
    expect(lookName(create(MaterialSchema, {}))).toBe('demo');
  });
});
