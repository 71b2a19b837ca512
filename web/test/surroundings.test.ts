import { readFileSync } from 'node:fs';
import { expect, it } from 'vitest';

function read(path: string): string {
  return readFileSync(new URL(`../../${path}`, import.meta.url), 'utf8');
}

/** The numbers that a pattern's groups find in a text, colours in any notation. */
function numbers(text: string, pattern: RegExp): number[] {
  return (pattern.exec(text) ?? []).slice(1).map((each) => Number(each.replace('#', '0x')));
}

it('floor, solids, light and background are those of the server’s pictures', () => {
  const drawn = read('server/service/picture/scene_look.cc');
  const [stage, colliders, css] = ['scene/stage.ts', 'scene/colliders.ts', 'style/base.css'].map((file) => read(`web/src/${file}`));
  const sky = (name: string) => numbers(css, new RegExp(`--sky-${name}: light-dark\\((#\\w+), (#\\w+)\\)`));
  const floor = numbers(stage, /setColors\(isDark \? (\w+) : (\w+), isDark \? (\w+) : (\w+)\)/);
  const below = numbers(stage, /groundColor.set\(isDark \? (\w+) : (\w+)\)/);
  const intensity = numbers(stage, /sky.intensity = isDark \? ([\d.]+) : ([\d.]+)/);
  const theme = (isDark: number) => [
    ...[sky('top')[isDark], sky('bottom')[isDark], floor[1 - isDark], floor[3 - isDark], below[1 - isDark], intensity[1 - isDark]],
  ];
  const ofServer = (name: string) => (/\{(.*)\}/.exec(drawn.split(`k${name}Theme`)[1]) ?? [])[1].split(', ').map(Number);
  expect(ofServer('Light')).toEqual(theme(0));
  expect(ofServer('Dark')).toEqual(theme(1));
  expect(numbers(drawn, /kSolids = (\w+)/)).toEqual(numbers(colliders, /color: (\w+)/));
  const sun = numbers(stage, /DirectionalLight\((\w+), ([\d.]+)\)/);
  expect([...numbers(drawn, /kSun = (\w+)/), ...numbers(drawn, /kSunIntensity = ([\d.]+)/)]).toEqual(sun);
  const direction = numbers(stage, /kLightDirection = new Vector3\((\S+), (\S+), (\S+?)\)/);
  expect(numbers(drawn, /kTowardsSun\{(\S+), (\S+), (\S+)\}/)).toEqual(direction);
});
