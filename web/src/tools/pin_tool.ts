import { create } from '@bufbuild/protobuf';
import type { Vector2 } from 'three';
import { call } from '../api';
import { InteractionService } from '../gen/kerf/v1/interaction_pb';
import { RegionSchema } from '../gen/kerf/v1/conditions_pb';
import type { Pointer, Tool, Viewer } from './tool';

// A tap this near to a pin, in CSS pixels, is meant for it.
const kPinReachPx = 9;

/** A tap on a vertex pins it where it is, or lets it go. */
export class PinTool implements Tool {
  readonly id = 'pin';
  readonly cursor = 'cell';

  constructor(private readonly viewer: Viewer) {}

  enter(): void {}
  leave(): void {}
  press(): boolean {
    return false;
  }
  drag(): void {}
  release(): void {}
  abandon(): void {}
  update(): void {}

  tap(pointer: Pointer): void {
    const vertex = this.pinNear(pointer.px) ?? this.viewer.surface?.pick(pointer.ray)?.vertex;
    if (vertex !== undefined) void this.toggle(vertex);
  }

  // The balls on the pins reach beyond the sheet, and a pin is more often meant than its neighbour.
  private pinNear(px: Vector2): number | undefined {
    const { surface, stage, sheet } = this.viewer;
    let nearest = kPinReachPx;
    let found: number | undefined;
    for (const vertex of sheet?.pinnedVertices ?? []) {
      if (!surface?.hasMaterial(vertex)) continue;
      const distance = stage.project(surface.vertexPosition(vertex))?.distanceTo(px) ?? Infinity;
      if (distance < nearest) [nearest, found] = [distance, vertex];
    }
    return found;
  }

  private async toggle(vertex: number): Promise<void> {
    const pinned = new Set(this.viewer.sheet?.pinnedVertices ?? []);
    const isPinned = pinned.delete(vertex);
    if (!isPinned) pinned.add(vertex);
    const vertices = [...pinned].sort((a, b) => a - b);
    const pins =
      vertices.length === 0 ? [] : [create(RegionSchema, { region: { case: 'vertices', value: { vertices } } })];
    const done = await this.viewer.attempt(() =>
      call(InteractionService.method.setSheetPins, { name: this.viewer.sheetName, setPins: { pins } }),
    );
    if (!done) return;
    this.viewer.notify('info', `Vertex ${vertex} ${isPinned ? 'released' : 'pinned'} (${vertices.length} pinned)`);
    await this.viewer.refreshSheet();
  }
}
