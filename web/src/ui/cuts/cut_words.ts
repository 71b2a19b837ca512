import type { Curve } from '../../gen/kerf/v1/geometry_pb';
import { View_Layers } from '../../gen/kerf/v1/scene_pb';
import type { Cut } from '../../gen/kerf/v1/scene_pb';
import { lengthText } from '../../tools/cut_text';

const kTargets: Record<View_Layers, string> = {
  [View_Layers.LAYERS_UNSPECIFIED]: 'through what was seen',
  [View_Layers.NEAREST]: 'through what was seen',
  [View_Layers.ALL]: 'through every layer',
  [View_Layers.ONE_PIECE]: 'through one piece',
  [View_Layers.DEPTH_RANGE]: 'through a depth range',
};

function shapeText({ kind }: Pick<Curve, 'kind'>): string {
  switch (kind.case) {
    case 'bezier':
      return 'Curve';
    case 'polyline':
      return kind.value.points.length === 2 ? 'Straight line' : 'Lines';
    case 'circle':
      return 'Circle';
    case 'ellipse':
      return 'Ellipse';
    case 'path': {
      const { subpaths } = kind.value;
      return subpaths.length > 1 ? `Drawing of ${subpaths.length.toLocaleString('en')} lines` : 'Curve';
    }
    default:
      return 'Drawing';
  }
}

/** Says what was drawn for a cut: "Circle, dashed, 3 mm wide, through every layer". */
export function cutWords({ curve, view, dash, widthM }: Cut): string {
  return [
    curve ? shapeText(curve) : 'Drawing',
    ...(dash.length > 0 ? ['dashed'] : []),
    ...(widthM > 0 ? [`${lengthText(widthM)} wide`] : []),
    ...(view ? [kTargets[view.layers] ?? 'through the picture'] : []),
  ].join(', ');
}

/** Returns the number of a cut: 12 for sheets/demo/cuts/12. */
export function cutNumber(name: string): string {
  return name.slice(name.lastIndexOf('/') + 1);
}
