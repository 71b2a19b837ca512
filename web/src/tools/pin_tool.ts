import { create } from '@bufbuild/protobuf';
import { call } from '../api';
import { InteractionService } from '../gen/kerf/v1/interaction_pb';
import { PinRegionSchema } from '../gen/kerf/v1/scene_pb';
import type { Pointer, Tool, Viewer } from './tool';

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
  update(): void {}
  key(): boolean {
    return false;
  }

  tap(pointer: Pointer): void {
    const hit = this.viewer.surface?.pick(pointer.ray);
    if (hit) void this.toggle(hit.vertex);
  }

  private async toggle(vertex: number): Promise<void> {
    const pinned = new Set(this.viewer.sheet?.pinnedVertices ?? []);
    const isPinned = pinned.delete(vertex);
    if (!isPinned) pinned.add(vertex);
    const vertices = [...pinned].sort((a, b) => a - b);
    const pins = vertices.length === 0 ? []
      : [create(PinRegionSchema, { region: { case: 'vertices', value: { vertices } } })];
    const done = await this.viewer.attempt(
      () => call(InteractionService.method.setSheetPins, { name: this.viewer.sheetName, setPins: { pins } }));
    if (!done) return;
    this.viewer.notify('info', `Vertex ${vertex} ${isPinned ? 'released' : 'pinned'} (${vertices.length} pinned)`);
    await this.viewer.refreshSheet();
  }
}
