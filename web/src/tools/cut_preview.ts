import type { Vector3 } from 'three';
import { FatLines } from '../scene/fat_lines';
import type { Stage } from '../scene/stage';

/**
 * The curve about to be cut and, thinner and white, its control polygon, over the sheet: a bright line in a dark rim
 * reads everywhere.
 */
export class CutPreview {
  private readonly polygonRim = new FatLines({ color: 0x10151c, width: 5, onTop: true });
  private readonly polygon = new FatLines({ color: 0xffffff, width: 2.25, onTop: true });
  private readonly curveRim = new FatLines({ color: 0x10151c, width: 7, onTop: true });
  private readonly curve = new FatLines({ color: 0xffd23f, width: 4, onTop: true });

  constructor(stage: Stage) {
    [this.polygonRim, this.polygon, this.curveRim, this.curve].forEach((lines, i) => {
      lines.object.renderOrder = 10 + i;
      stage.scene.add(lines.object);
    });
    this.clear();
  }

  show(curve: readonly (Vector3 | undefined)[], polygon: readonly (Vector3 | undefined)[]): void {
    const line = coordinates(curve);
    this.curveRim.setPolyline(line);
    this.curve.setPolyline(line);
    const corners = coordinates(polygon);
    this.polygonRim.setPolyline(corners);
    this.polygon.setPolyline(corners);
  }

  clear(): void {
    this.show([], []);
  }
}

function coordinates(points: readonly (Vector3 | undefined)[]): number[] {
  return points.flatMap((point) => (point ? [point.x, point.y, point.z] : []));
}
