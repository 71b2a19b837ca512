import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  DynamicDrawUsage,
  GreaterDepth,
  Group,
  Mesh,
  MeshBasicMaterial,
  NotEqualStencilFunc,
  ReplaceStencilOp,
} from 'three';
import type { ColorRepresentation } from 'three';
import { kNearerOffset } from './depth_offsets';

/** Draws triangles on the cloth, which may overlap: each pixel is coloured once, and faintly where a fold hides it. */
export class SheetFill {
  readonly object = new Group();
  private readonly geometry = new BufferGeometry();
  private corners = this.allocate(64);

  constructor(color: ColorRepresentation, opacity: number, faintOpacity: number, order: number) {
    // The two stencil values differ from each other and from the lines' value, because each prevents colouring its own
    // pixels twice.
    const [seen, hidden] = [
      { opacity, stencilRef: 2 },
      { opacity: faintOpacity, stencilRef: 3, depthFunc: GreaterDepth },
    ].map((own) => {
      const material = new MeshBasicMaterial({
        color,
        transparent: true,
        depthWrite: false,
        side: DoubleSide,
        stencilWrite: true,
        stencilFunc: NotEqualStencilFunc,
        stencilZPass: ReplaceStencilOp,
        ...kNearerOffset,
        ...own,
      });
      const mesh = new Mesh(this.geometry, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = order;
      return mesh;
    });
    this.object.add(seen, hidden);
    this.begin(0);
  }

  /** Returns room for `count` corners, 3 numbers each, metres. The caller fills it before the next draw. */
  begin(count: number): Float32Array {
    if (3 * count > this.corners.array.length) this.corners = this.allocate(Math.max(count, (2 * this.corners.array.length) / 3));
    this.geometry.setDrawRange(0, count);
    this.object.visible = count > 0;
    this.corners.clearUpdateRanges();
    this.corners.addUpdateRange(0, 3 * count);
    this.corners.needsUpdate = true;
    return this.corners.array as Float32Array;
  }

  private allocate(count: number): BufferAttribute {
    const corners = new BufferAttribute(new Float32Array(3 * Math.ceil(count)), 3).setUsage(DynamicDrawUsage);
    this.geometry.dispose();
    this.geometry.setAttribute('position', corners);
    return corners;
  }
}
