import { ArrowHelper, Vector3 } from 'three';
import type { Box3, Object3D } from 'three';
import type { Wind } from '../gen/kerf/v1/scene_pb';

const kColor = 0x2f86d6;
// Wind speed, m/s, at which the arrow has its full length.
const kFull = 20;

/** An arrow above the scene in the direction of the wind, longer for stronger wind; hidden in still air. */
export class WindView {
  private readonly arrow = new ArrowHelper(new Vector3(1, 0, 0), new Vector3(), 1, kColor);
  private wind: Wind | undefined;
  private reach = 1;

  constructor() {
    this.arrow.visible = false;
  }

  get object(): Object3D {
    return this.arrow;
  }

  set(wind: Wind | undefined): void {
    this.wind = wind;
    this.update();
  }

  /** @param box  box around the scene, metres; the arrow is above its middle */
  fit(box: Box3): void {
    const size = box.getSize(new Vector3());
    this.reach = 0.5 * Math.max(size.x, size.y, size.z);
    this.arrow.position.copy(box.getCenter(new Vector3())).setZ(box.max.z + 0.15 * this.reach);
    this.update();
  }

  private update(): void {
    const { x = 0, y = 0, z = 0 } = this.wind?.velocityMps ?? {};
    const velocity = new Vector3(x, y, z);
    const speed = velocity.length();
    this.arrow.visible = speed > 0;
    if (speed === 0) return;
    const length = this.reach * (0.25 + 0.75 * Math.min(1, speed / kFull));
    this.arrow.setDirection(velocity.divideScalar(speed));
    this.arrow.setLength(length, 0.25 * length, 0.12 * length);
  }
}
