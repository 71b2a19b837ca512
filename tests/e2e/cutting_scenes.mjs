// Sheets for cuts that nothing moves, and the newest cut of one.
import { post } from './harness.mjs';

export const kTall = { viewport: { width: 1280, height: 960 }, colorScheme: 'light' };

export const kFlatScene = {
  grid: { columns: 41, rows: 41, widthM: 1, heightM: 1 },
  placement: { xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  gravityMps2: {},
};


// A sheet folded in the middle, one half behind the other, that nothing moves.
export function foldedScene() {
  const side = 31;
  const material = (i) => [i % side, Math.floor(i / side)].map((n) => n / (side - 1));
  const numbers = Array.from({ length: side * side }, (_, i) => material(i));
  const vertices = numbers.map(([u, v]) => `v ${u} ${0.4 * (v - 0.5)} ${Math.sqrt(0.84) * Math.abs(v - 0.5)}`);
  const faces = numbers.flatMap(([u, v], i) => {
    const corners = [i + 1, i + 2, i + 2 + side, i + 1 + side].map((vertex) => `${vertex}/${vertex}`);
    return u < 1 && v < 1 ? [`f ${corners.slice(0, 3).join(' ')}`, `f ${corners[0]} ${corners[2]} ${corners[3]}`] : [];
  });
  const text = [...vertices, ...numbers.map(([u, v]) => `vt ${u} ${v}`), ...faces].join('\n');
  return { obj: { text }, gravityMps2: {}, material: { preset: 'paper' } };
}

export async function lastCut(url, sheet) {
  return (await post(url, 'CutService/ListCuts', { parent: sheet })).cuts?.at(-1);
}
