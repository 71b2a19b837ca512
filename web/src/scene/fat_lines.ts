import {
  DynamicDrawUsage,
  GreaterDepth,
  InstancedInterleavedBuffer,
  InterleavedBufferAttribute,
  NotEqualStencilFunc,
  ReplaceStencilOp,
} from 'three';
import type { ColorRepresentation } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { kNearerOffset } from './depth_offsets';

export interface FatLineStyle {
  color: ColorRepresentation;
  /** CSS pixels */
  width: number;
  opacity?: number;
  /** Draws the lines over everything, even where something is in front. */
  onTop?: boolean;
  /** For lines on the cloth: draws only their visible parts, or only the parts that something hides. */
  part?: 'seen' | 'hidden';
}

function lineMaterial({ color, width, opacity = 1, onTop = false, part }: FatLineStyle): LineMaterial {
  const material = new LineMaterial({
    color,
    linewidth: width,
    // Lines over other things count as transparent, because transparent objects are drawn after all others, by
    // renderOrder.
    transparent: onTop || part !== undefined || opacity < 1,
    opacity,
    depthTest: !onTop,
    depthWrite: false,
  });
  if (part === undefined) return material;
  Object.assign(material, kNearerOffset);
  if (part === 'seen') return material;
  material.depthFunc = GreaterDepth;
  // Colours each pixel once, because overlapping ends of neighbours would otherwise be less faint than the rest.
  material.stencilWrite = true;
  material.stencilRef = 1;
  material.stencilFunc = NotEqualStencilFunc;
  material.stencilZPass = ReplaceStencilOp;
  return material;
}

/** Line segments with a width in pixels. Their ends are rewritten in place for each frame. */
export class FatLines {
  readonly object: LineSegments2;
  readonly material: LineMaterial;
  private buffer: InstancedInterleavedBuffer;

  constructor(style: FatLineStyle) {
    this.material = lineMaterial(style);
    this.object = new LineSegments2(new LineSegmentsGeometry(), this.material);
    this.object.frustumCulled = false;
    if (style.onTop) this.object.renderOrder = 10;
    this.buffer = this.allocate(16);
    this.object.geometry.instanceCount = 0;
  }

  /** Draws the same segments once more in another style, over the styles so far. */
  addLook(style: FatLineStyle): LineMaterial {
    const material = lineMaterial(style);
    const again = new LineSegments2(this.object.geometry, material);
    again.frustumCulled = false;
    again.renderOrder = this.object.renderOrder + this.object.children.length + 1;
    this.object.add(again);
    return material;
  }

  /**
   * Returns room for `count` segments, 6 numbers each (start, end; metres). The caller fills it before the next draw.
   */
  begin(count: number): Float32Array {
    if (6 * count > this.buffer.array.length)
      this.buffer = this.allocate(Math.max(count, this.buffer.array.length / 3));
    this.object.geometry.instanceCount = count;
    this.object.visible = count > 0;
    this.buffer.clearUpdateRanges();
    this.buffer.addUpdateRange(0, 6 * count);
    this.buffer.needsUpdate = true;
    return this.buffer.array as Float32Array;
  }

  /** Draws the polyline through n points; 3 n numbers, metres. */
  setPolyline(points: ArrayLike<number>): void {
    const count = Math.max(0, points.length / 3 - 1);
    const ends = this.begin(count);
    for (let i = 0; i < count; ++i) {
      for (let k = 0; k < 6; ++k) ends[6 * i + k] = points[3 * i + k];
    }
  }

  private allocate(segments: number): InstancedInterleavedBuffer {
    const buffer = new InstancedInterleavedBuffer(new Float32Array(6 * Math.ceil(segments)), 6, 1);
    buffer.setUsage(DynamicDrawUsage);
    const { geometry } = this.object;
    geometry.dispose();
    geometry.setAttribute('instanceStart', new InterleavedBufferAttribute(buffer, 3, 0));
    geometry.setAttribute('instanceEnd', new InterleavedBufferAttribute(buffer, 3, 3));
    return buffer;
  }
}
