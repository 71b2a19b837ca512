import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial, Vector3 } from 'three';
import type { SheetArrays } from '../stream/sheet_copy';

/** Returns the vertices of a piece's triangles, 3 per triangle. */
export function trianglesOf(mirror: SheetArrays, label: number): Uint32Array {
  const corners: number[] = [];
  for (let slot = 0; slot < mirror.numSlots; ++slot) {
    if (mirror.pieces[slot] !== label || mirror.triangles[3 * slot] < 0) continue;
    for (let corner = 0; corner < 3; ++corner) corners.push(mirror.triangles[3 * slot + corner]);
  }
  return Uint32Array.from(corners);
}

/** Returns the mean of the corners of a piece's triangles; world, metres. */
export function pieceCentre(mirror: SheetArrays, label: number): Vector3 {
  const corners = trianglesOf(mirror, label);
  const sum = new Vector3();
  const at = new Vector3();
  for (const vertex of corners) sum.add(at.fromArray(mirror.positions, 3 * vertex));
  return sum.divideScalar(Math.max(1, corners.length));
}

/** Highlights one piece by a translucent colour drawn over the cloth. */
export class PieceHighlight {
  readonly object = new Mesh(
    new BufferGeometry(),
    new MeshBasicMaterial({ color: 0xffd23f, transparent: true, opacity: 0.55, side: DoubleSide, depthWrite: false }),
  );
  private label: number | undefined;
  private shownLabel: number | undefined;
  private shownVersion = -1;

  constructor() {
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  get isOn(): boolean {
    return this.label !== undefined;
  }

  /** @param label  label of the piece in the mirror's frames; undefined: no piece is highlighted */
  set(label: number | undefined): void {
    this.label = label;
  }

  /** @param positions  position attribute of the sheet's mesh, which is shared */
  update(mirror: SheetArrays, positions: BufferAttribute): void {
    const { object, label } = this;
    object.visible = label !== undefined;
    if (label === undefined) return;
    const { geometry } = object;
    const isSame = geometry.getAttribute('position') === positions && label === this.shownLabel;
    if (isSame && mirror.topologyVersion === this.shownVersion) return;
    geometry.setAttribute('position', positions);
    geometry.setIndex(new BufferAttribute(trianglesOf(mirror, label), 1));
    [this.shownLabel, this.shownVersion] = [label, mirror.topologyVersion];
  }
}
