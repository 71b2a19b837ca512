import type { Vector3 } from 'three';
import { FatLines } from '../scene/fat_lines';
import type { Stage } from '../scene/stage';

/** The curve about to be cut and its control polygon, over the sheet: a bright line in a dark rim reads everywhere. */
export class CutPreview {
  private readonly polygon = new FatLines({ color: 0xffffff, width: 1.5, opacity: 0.55, onTop: true });
  private readonly rim = new FatLines({ color: 0x10151c, width: 6, onTop: true });
  private readonly curve = new FatLines({ color: 0xffd23f, width: 3, onTop: true });

  constructor(stage: Stage) {
    [this.polygon, this.rim, this.curve].forEach((lines, i) => {
      lines.object.renderOrder = 10 + i;
      stage.scene.add(lines.object);
    });
    this.clear();
  }

  show(curve: readonly (Vector3 | undefined)[], polygon: readonly (Vector3 | undefined)[]): void {
    const line = coordinates(curve);
    this.rim.setPolyline(line);
    this.curve.setPolyline(line);
    this.polygon.setPolyline(coordinates(polygon));
  }

  clear(): void {
    this.show([], []);
  }
}

function coordinates(points: readonly (Vector3 | undefined)[]): number[] {
  return points.flatMap((point) => (point ? [point.x, point.y, point.z] : []));
}
