import { Group } from 'three';
import type { Collider } from '../gen/kerf/v1/scene_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Surface } from '../geometry/surface';
import { ColliderView } from './colliders';
import { PinView } from './pin_view';
import { SheetLooks } from './sheet_looks';
import { SheetView } from './sheet_view';
import type { Stage } from './stage';
import { WindView } from './wind_view';
import { worldBox } from './world_box';

// Radius of a pin, as a share of the sheet's larger side.
const kPinRadius = 0.009;

/** A sheet and what is around it: colliders, pins, wind. */
export class SheetScene {
  readonly object = new Group();
  readonly view = new SheetView();
  private readonly pins = new PinView();
  private readonly wind = new WindView();
  private readonly colliders: ColliderView;
  private readonly looks = new SheetLooks();
  private isDrawn = true;
  private isHiding = false;

  constructor(private readonly stage: Stage) {
    this.colliders = new ColliderView(stage.ground);
    this.object.add(this.view.object, this.pins.object, this.colliders.object, this.wind.object);
    stage.scene.add(this.object);
  }

  /** Moves the camera so that sheet and colliders are in view. */
  fit({ mirror }: Surface, colliders: readonly Collider[]): void {
    const box = worldBox(mirror, colliders);
    this.stage.fit(box);
    this.wind.fit(box);
    // Sizes the floor for the new view.
    this.colliders.set(colliders);
  }

  /** Shows the server's settings, which frames do not contain. */
  set(sheet: Sheet): void {
    const { scene, pinnedVertices } = sheet;
    this.looks.show(sheet, this.view);
    this.wind.set(scene?.wind);
    this.pins.set(pinnedVertices);
    this.colliders.set(scene?.colliders ?? []);
  }

  /** Sets whether the page draws sheet and colliders; otherwise the server's picture shows them. */
  setDrawn(isDrawn: boolean): void {
    this.isDrawn = isDrawn;
    this.show();
  }

  /** Sets whether sheet and solids hide what lies over a picture of the server. False if nothing changed. */
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
