import { Group, InstancedMesh, Matrix4, MeshStandardMaterial, SphereGeometry, Vector3 } from 'three';
import type { Surface } from '../geometry/surface';

/** Small balls on the pinned vertices. */
export class PinView {
  readonly object = new Group();
  private readonly material = new MeshStandardMaterial({ color: 0xf2b01e, roughness: 0.35, metalness: 0.1 });
  private readonly ball = new SphereGeometry(1, 20, 14);
  private balls = this.allocate(16);
  private vertices: readonly number[] = [];

  set(vertices: readonly number[]): void {
    this.vertices = vertices;
    if (vertices.length > this.balls.instanceMatrix.count) {
      this.object.remove(this.balls);
      this.balls.dispose();
      this.balls = this.allocate(2 * vertices.length);
    }
  }

  /** @param radius  metres */
  update(surface: Surface, radius: number): void {
    const { mirror } = surface;
    const matrix = new Matrix4();
    const at = new Vector3();
    let count = 0;
    for (const vertex of this.vertices) {
      // A pin disappears with its material; the server's list without the pin has not arrived yet.
      if (!surface.hasMaterial(vertex)) continue;
      at.fromArray(mirror.positions, 3 * vertex);
      this.balls.setMatrixAt(count++, matrix.makeScale(radius, radius, radius).setPosition(at));
    }
    this.balls.count = count;
    this.balls.instanceMatrix.needsUpdate = true;
  }

  private allocate(capacity: number): InstancedMesh {
    const balls = new InstancedMesh(this.ball, this.material, capacity);
    balls.count = 0;
    balls.castShadow = true;
    balls.frustumCulled = false;
    this.object.add(balls);
    return balls;
  }
}
