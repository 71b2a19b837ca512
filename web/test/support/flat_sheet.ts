import { Ray, Vector2, Vector3 } from 'three';
import { Surface } from '../../src/geometry/surface';
import { SheetMirror } from '../../src/stream/mirror';

/** A unit square of two triangles that lies at (x, y, 0); one of 4 vertices may be moved in `mirror.positions`. */
export function flatSheet(): { mirror: SheetMirror; surface: Surface } {
  const mirror = new SheetMirror();
  mirror.numVertices = 4;
  mirror.materialPositions = Float32Array.of(0, 0, 1, 0, 1, 1, 0, 1);
  mirror.positions = Float32Array.of(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0);
  mirror.triangles = Int32Array.of(0, 1, 2, 0, 2, 3);
  mirror.numSlots = 2;
  mirror.topologyVersion = 1;
  return { mirror, surface: new Surface(mirror) };
}

/** A stage that looks straight down: 100 CSS pixels a metre, from the origin. */
export class StageFromAbove {
  readonly sizePx = new Vector2(100, 100);
  numInvalidated = 0;

  rayAt({ x, y }: Vector2): Ray {
    return new Ray(new Vector3(x / 100, y / 100, 5), new Vector3(0, 0, -1));
  }

  project({ x, y, z }: Vector3): Vector2 | undefined {
    return z > 5 ? undefined : new Vector2(100 * x, 100 * y);
  }

  invalidate(): void {
    this.numInvalidated += 1;
  }
}
