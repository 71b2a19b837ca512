import { Plane, Vector3 } from 'three';
import { FatLines } from '../scene/fat_lines';
import type { Rejection } from '../gen/kerf/v1/stream_pb';
import type { GestureStream } from '../sheet/open_sheet';
import { springLook } from './spring_look';
import type { Pointer, Tool, Viewer } from './tool';

interface ActiveGrab {
  id: string;
  vertex: number;
  watch: NonNullable<GestureStream['watch']>;
  /** Plane through the grabbed point that faces the camera; the pointer moves the target in this plane. */
  plane: Plane;
  target: Vector3;
  isTargetNew: boolean;
}

// Wait before a release is repeated that the server refused because its queue was full.
const kReleaseRetryMs = 100;

/** Drags a vertex by a spring, whose look shows the force. A target is sent at most once per drawn picture. */
export class GrabTool implements Tool {
  readonly id = 'grab';
  readonly cursor = 'pointer';
  private readonly spring = new FatLines({ color: 0xff7a1a, width: 3, onTop: true });
  private active: ActiveGrab | undefined;
  private count = 0;
  // Ids of grabs whose release waits to be sent again.
  private readonly retrying = new Set<string>();
  private readonly idPrefix = `web-${crypto.getRandomValues(new Uint32Array(1))[0].toString(36)}`;

  constructor(private readonly viewer: Pick<Viewer, 'stage' | 'shown' | 'live' | 'notices'>) {
    viewer.stage.scene.add(this.spring.object);
    this.spring.begin(0);
  }

  enter(): void {}

  leave(): void {
    this.release();
  }

  /** Grabs a vertex, and releases the one held before. */
  press(pointer: Pointer): boolean {
    this.release();
    const { stage } = this.viewer;
    const { surface } = this.viewer.shown;
    const { watch } = this.viewer.live;
    const hit = surface?.pick(pointer.ray);
    if (!surface || !watch || !hit) return false;
    const target = surface.vertexPosition(hit.vertex);
    const id = `${this.idPrefix}-${++this.count}`;
    if (!watch.send({ case: 'grab', value: { grabId: id, point: { case: 'vertex', value: hit.vertex }, target } })) {
      this.viewer.notices.notify('error', 'Not connected: the sheet cannot be pulled');
      return false;
    }
    const plane = new Plane().setFromNormalAndCoplanarPoint(stage.camera.getWorldDirection(new Vector3()), target);
    this.active = { id, vertex: hit.vertex, watch, plane, target, isTargetNew: false };
    stage.invalidate();
    return true;
  }

  drag(pointer: Pointer): void {
    if (!this.active) return;
    if (pointer.ray.intersectPlane(this.active.plane, this.active.target)) {
      this.active.isTargetNew = true;
      this.viewer.stage.invalidate();
    }
  }

  release(): void {
    if (!this.active) return;
    this.active.watch.send({ case: 'release', value: { grabId: this.active.id } });
    this.forget();
  }

  abandon(): void {
    this.release();
  }

  tap(): void {}

  /** Releases the grab; false if nothing is held. */
  escape(): boolean {
    const isHolding = this.active !== undefined;
    this.release();
    return isHolding;
  }

  update(): void {
    const { active } = this;
    const { surface } = this.viewer.shown;
    const { watch } = this.viewer.live;
    if (!active || !surface) return;
    // The grab has ended with its stream, or its vertex no longer exists after a reset.
    if (watch !== active.watch || watch.state !== 'live' || active.vertex >= surface.mirror.numVertices) {
      this.forget();
      return;
    }
    if (active.isTargetNew) {
      active.watch.send({ case: 'drag', value: { grabId: active.id, target: active.target } });
      active.isTargetNew = false;
    }
    // If the vertex loses its material, the server moves the grab to the nearest vertex that has some.
    const at = surface.vertexPosition(surface.nearestWithMaterial(active.vertex));
    this.spring.setPolyline([...at.toArray(), ...active.target.toArray()]);
    const { min, max } = surface.locator;
    const look = springLook(at.distanceTo(active.target), Math.hypot(max.x - min.x, max.y - min.y));
    this.spring.material.linewidth = look.widthPx;
    this.spring.material.color.copy(look.color);
  }

  rejected({ grabId, message, reason }: Rejection): void {
    const { active } = this;
    const isFull = reason === 'QUEUE_FULL';
    if (active?.id !== grabId) {
      // The page has already released this grab, so it must not continue to pull on the server.
      if (isFull) this.retryRelease(grabId);
      else if (reason !== 'GRAB_NOT_FOUND') this.refused(message || reason);
      return;
    }
    if (isFull) {
      // The next drawing sends the lost target again. If the grab itself was refused, the server answers
      // GRAB_NOT_FOUND.
      active.isTargetNew = true;
      this.viewer.stage.invalidate();
      return;
    }
    this.refused(message || reason);
    this.forget();
  }

  private refused(why: string): void {
    this.viewer.notices.notify('error', `The server refused the pull: ${why}`);
  }

  // Sends the release again on the stream that refused it. If the page has another stream by then, the grab has ended
  // with the old one.
  private retryRelease(grabId: string): void {
    const { live } = this.viewer;
    const { watch } = live;
    if (this.retrying.has(grabId)) return;
    this.retrying.add(grabId);
    setTimeout(() => {
      this.retrying.delete(grabId);
      if (watch === live.watch) watch?.send({ case: 'release', value: { grabId } });
    }, kReleaseRetryMs);
  }

  private forget(): void {
    this.active = undefined;
    this.spring.begin(0);
    this.viewer.stage.invalidate();
  }
}
