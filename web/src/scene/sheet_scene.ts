import { Group } from 'three';
import type { Collider } from '../gen/kerf/v1/scene_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Surface } from '../geometry/surface';
import { ColliderView } from './colliders';
import { PinView } from './pin_view';
import { SheetView } from './sheet_view';
import type { Stage } from './stage';
import { WindView } from './wind_view';
import { worldBox } from './world_box';

// The radius of a pin, in parts of the sheet's larger side.
const kPinRadius = 0.009;

/** A sheet and what is around it: colliders, pins, wind. */
export class SheetScene {
  readonly object = new Group();
  readonly view = new SheetView();
  private readonly pins = new PinView();
  private readonly wind = new WindView();
  private readonly colliders: ColliderView;
  private isDrawn = true;
  private isHiding = false;

  constructor(private readonly stage: Stage) {
    this.colliders = new ColliderView(stage.ground);
    this.object.add(this.view.object, this.pins.object, this.colliders.object, this.wind.object);
    stage.scene.add(this.object);
  }

  /** Looks at the whole of it. */
  fit({ mirror }: Surface, colliders: readonly Collider[]): void {
    const box = worldBox(mirror, colliders);
    this.stage.fit(box);
    this.wind.fit(box);
    // The floor reaches as far as is seen.
    this.colliders.set(colliders);
  }

  /** Takes the settings that the server has, which are not in frames. */
  set({ scene, pinnedVertices }: Sheet): void {
    this.wind.set(scene?.wind);
    this.pins.set(pinnedVertices);
    this.colliders.set(scene?.colliders ?? []);
  }

  /** Sheet and colliders are drawn here, or are in the picture that the server draws. */
  setDrawn(isDrawn: boolean): void {
    this.isDrawn = isDrawn;
    this.show();
  }

  /** Lets sheet and solids hide what lies over a picture of the server, or not; false: it was so before. */
  setHiding(isHiding: boolean): boolean {
    if (isHiding === this.isHiding) return false;
    this.isHiding = isHiding;
    this.show();
    return true;
  }

  /** Takes the newest frame. */
  update(surface: Surface): void {
    this.view.update(surface);
    const { min, max } = surface.locator;
    this.pins.update(surface, kPinRadius * Math.max(max.x - min.x, max.y - min.y));
  }

  private show(): void {
    for (const part of [this.view, this.colliders]) {
      part.setDrawn(this.isDrawn);
      part.setHiding(this.isHiding && !this.isDrawn);
    }
  }
}
