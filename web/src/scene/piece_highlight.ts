import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial, Vector3 } from 'three';
import type { SheetArrays } from '../stream/sheet_copy';

/** Corners of a piece's triangles, 3 numbers each. */
export function trianglesOf(mirror: SheetArrays, label: number): Uint32Array {
  const corners: number[] = [];
  for (let slot = 0; slot < mirror.numSlots; ++slot) {
    if (mirror.pieces[slot] !== label || mirror.triangles[3 * slot] < 0) continue;
    for (let corner = 0; corner < 3; ++corner) corners.push(mirror.triangles[3 * slot + corner]);
  }
  return Uint32Array.from(corners);
}

/** World, metres: mean of the corners of a piece's triangles. */
export function pieceCentre(mirror: SheetArrays, label: number): Vector3 {
  const corners = trianglesOf(mirror, label);
  const sum = new Vector3();
  const at = new Vector3();
  for (const vertex of corners) sum.add(at.fromArray(mirror.positions, 3 * vertex));
  return sum.divideScalar(Math.max(1, corners.length));
}

/** One piece shines through its own colours, in front of the cloth. */
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

  /** @param label  of the piece in the mirror's frames; undefined: none */
  set(label: number | undefined): void {
    this.label = label;
  }

  /** @param positions  attribute of the sheet's own mesh */
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
