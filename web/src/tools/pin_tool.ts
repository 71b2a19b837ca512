import { create } from '@bufbuild/protobuf';
import type { Vector2 } from 'three';
import { call } from '../api';
import { InteractionService } from '../gen/kerf/v1/interaction_pb';
import { RegionSchema } from '../gen/kerf/v1/conditions_pb';
import { Newest } from '../newest';
import type { Pointer, Tool, Viewer } from './tool';

// A tap within this distance of a pin, CSS pixels, is meant for the pin.
const kPinReachPx = 9;

interface PinWish {
  /** sheets/{sheet} */
  name: string;
  pinned: ReadonlySet<number>;
  /** The vertex that was added or removed last. */
  vertex: number;
}

/** A tap on a vertex pins it at its present place, or unpins it. */
export class PinTool implements Tool {
  readonly id = 'pin';
  readonly cursor = 'cell';

  // The pins last requested; undefined once the sheet's settings have them.
  private wish: PinWish | undefined;
  private readonly newest = new Newest<PinWish>(
    (name, wish) => this.send(name, wish),
    () => this.answered(),
  );

  constructor(private readonly viewer: Pick<Viewer, 'stage' | 'shown' | 'live' | 'notices'>) {}

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
    const vertex = this.pinNear(pointer.px) ?? this.viewer.shown.surface?.pick(pointer.ray)?.vertex;
    if (vertex !== undefined) this.toggle(vertex);
  }

  // Returns the pin near a tap: its ball reaches beyond the sheet, and a pin is more often meant than a vertex beside
  // it.
  private pinNear(px: Vector2): number | undefined {
    const { stage } = this.viewer;
    const { surface, sheet } = this.viewer.shown;
    let nearest = kPinReachPx;
    let found: number | undefined;
    for (const vertex of sheet?.pinnedVertices ?? []) {
      if (!surface?.hasMaterial(vertex)) continue;
      const distance = stage.project(surface.vertexPosition(vertex))?.distanceTo(px) ?? Infinity;
      if (distance < nearest) [nearest, found] = [distance, vertex];
    }
    return found;
  }

  // Each request sets all pins, so it starts from the pins last requested, even if they are not answered yet.
  private toggle(vertex: number): void {
    const { sheetName: name } = this.viewer.live;
    const { sheet } = this.viewer.shown;
    const before = this.wish?.name === name ? this.wish.pinned : sheet?.pinnedVertices;
    if (!before) return;
    const pinned = new Set(before);
    if (!pinned.delete(vertex)) pinned.add(vertex);
    this.wish = { name, pinned, vertex };
    this.newest.put(name, this.wish);
  }

  private async send(name: string, { pinned, vertex }: PinWish): Promise<void> {
    const vertices = [...pinned].sort((a, b) => a - b);
    const pins =
      vertices.length === 0 ? [] : [create(RegionSchema, { region: { case: 'vertices', value: { vertices } } })];
    const done = await this.viewer.notices.attempt(() =>
      call(InteractionService.method.setSheetPins, { name, setPins: { pins } }),
    );
    if (!done) return;
    const what = pinned.has(vertex) ? 'pinned' : 'released';
    this.viewer.notices.notify('info', `Vertex ${vertex} ${what} (${vertices.length} pinned)`);
  }

  private async answered(): Promise<void> {
    const { wish } = this;
    await this.viewer.live.refresh();
    if (wish === this.wish) this.wish = undefined;
  }
}
