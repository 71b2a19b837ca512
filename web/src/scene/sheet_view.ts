import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Group, LineBasicMaterial, LineSegments, Mesh } from 'three';
import { vertexNormals } from '../geometry/normals';
import type { LipFinder } from '../geometry/lips';
import type { Surface } from '../geometry/surface';
import type { SheetArrays } from '../stream/sheet_copy';
import { ClothMaterial } from './cloth_material';
import { kClothOffset } from './depth_offsets';
import { FatLines } from './fat_lines';
import { hidingMaterial, kHidingOrder } from './hiding_material';
import { LipHighlight } from './lip_highlight';
import type { MaterialLook } from './material_looks';
import { carriedColors, pieceColors } from './piece_colors';
import { PieceHighlight } from './piece_highlight';
import { strainColors, strainScaleEnd } from './strain_colors';

/** Gives for each slot the number of its look; undefined: the sheet has one look. */
export type LookFinder = (sheet: SheetArrays) => Uint8Array | undefined;

function upload(attribute: BufferAttribute, count: number): void {
  attribute.clearUpdateRanges();
  attribute.addUpdateRange(0, count);
  attribute.needsUpdate = true;
}

/** Draws one sheet: the lit surface, dark lines along border and lips, and the wireframe on request. */
export class SheetView {
  readonly object = new Group();

  // One for each look; the triangles of each follow one another in the index.
  private readonly cloths = [new ClothMaterial()];
  private readonly mesh = new Mesh<BufferGeometry, ClothMaterial[]>(new BufferGeometry(), this.cloths);
  private looksOf: LookFinder = () => undefined;
  private hasOwnColors = false;
  private readonly mask = new Mesh(this.mesh.geometry, hidingMaterial(kClothOffset));
  private readonly wires = new LineSegments(
    new BufferGeometry(),
    new LineBasicMaterial({ color: 0x05070a, transparent: true, opacity: 0.42, depthWrite: false }),
  );
  private readonly lips = new FatLines({ color: 0x10151c, width: 2 });
  private readonly highlighted = new PieceHighlight();
  private readonly highlightedLips = new LipHighlight();
  private surface: Surface | undefined;
  private isDrawn = true;
  private hasWires = false;
  private shownVersion = -1;
  private wiresVersion = -1;
  private colors: Float32Array | undefined;
  // The ids, version and scale that `colors` was computed from.
  private coloredIds: ReadonlyMap<number, number> | undefined;
  private coloredVersion = -1;
  private strainEnd = 0;

  constructor() {
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.mask.frustumCulled = false;
    this.mask.visible = false;
    this.mask.renderOrder = kHidingOrder;
    this.wires.frustumCulled = false;
    this.wires.visible = false;
    this.object.add(this.mesh, this.mask, this.wires, this.lips.object, this.highlighted.object);
    this.object.add(this.highlightedLips.object);
  }

  get isWireframe(): boolean {
    return this.hasWires;
  }

  /**
   * Shows the cloth in these looks, from the next update() on.
   * @param looksOf  a function that gives for each slot a number in `looks`; undefined: the first one everywhere. Another
   *   function if what it gives has changed.
   */
  setLooks(looks: readonly MaterialLook[], looksOf: LookFinder): void {
    while (this.cloths.length < looks.length) this.cloths.push(new ClothMaterial());
    this.setOwnColors(this.hasOwnColors);
    looks.forEach((look, i) => this.cloths[i].setLook(look));
    if (looksOf === this.looksOf) return;
    this.looksOf = looksOf;
    this.shownVersion = -1;
  }

  setWireframe(isOn: boolean): void {
    this.hasWires = isOn;
    this.wires.visible = isOn && this.isDrawn;
    if (this.wires.visible) this.updateWires();
  }

  /** Sets whether the sheet is drawn; highlights always are. Call update() afterwards. */
  setDrawn(isDrawn: boolean): void {
    this.isDrawn = isDrawn;
    this.mesh.visible = this.lips.object.visible = isDrawn;
    this.wires.visible = isDrawn && this.hasWires;
  }

  /** Sets whether the sheet hides what is behind it while it is not drawn. Call update() afterwards. */
  setHiding(isHiding: boolean): void {
    this.mask.visible = isHiding;
  }

  /** Highlights the piece with this label in the frames, from the next update() on; undefined: no piece. */
  highlight(label: number | undefined): void {
    this.highlighted.set(label);
  }

  /** Highlights the lips of a cut, from the next update() on; undefined: none. */
  highlightLips(find: LipFinder | undefined): void {
    this.highlightedLips.set(find);
  }

  /**
   * Colours the sheet by piece, or in the cloth's own colours.
   * @param ids  label -> id in the mirror's topology version; undefined while the ids are not known; null: the cloth's
   *   colours
   */
  colorByPiece(ids: ReadonlyMap<number, number> | undefined | null): void {
    if (!this.isDrawn) return;
    this.setOwnColors(ids !== null);
    if (ids === null || !this.surface) {
      this.colors = undefined;
      this.coloredIds = undefined;
      this.mesh.geometry.deleteAttribute('ownColor');
      return;
    }
    const { mirror } = this.surface;
    if (ids ? ids === this.coloredIds : this.colors && mirror.topologyVersion === this.coloredVersion) return;
    this.colors = ids ? pieceColors(mirror, ids) : carriedColors(mirror, this.colors ?? new Float32Array(0));
    this.coloredIds = ids;
    this.coloredVersion = mirror.topologyVersion;
    this.mesh.geometry.setAttribute('ownColor', new BufferAttribute(this.colors, 3));
  }

  /**
   * Colours the sheet by its strains, on a scale that adapts to the largest ones. Call it after update().
   * @returns the strain (-) at the end of the scale; undefined if the last frame had no strains, and the colours then
   *   stay
   */
  colorByStrain(): number | undefined {
    const strains = this.surface?.mirror.strains;
    if (!strains) return undefined;
    this.strainEnd = strainScaleEnd(strains, this.strainEnd);
    if (!this.isDrawn) return this.strainEnd;
    this.setOwnColors(true);
    this.coloredIds = undefined;
    this.colors = strainColors(strains, this.strainEnd, this.colors);
    const attribute = this.mesh.geometry.getAttribute('ownColor') as BufferAttribute | undefined;
    if (attribute?.array === this.colors) upload(attribute, this.colors.length);
    else this.mesh.geometry.setAttribute('ownColor', new BufferAttribute(this.colors, 3).setUsage(DynamicDrawUsage));
    return this.strainEnd;
  }

  /** Shows the mirror's newest state; `surface` is another object if it does not continue the one before. */
  update(surface: Surface): void {
    const { mirror } = surface;
    if (surface !== this.surface) this.shownVersion = this.coloredVersion = -1;
    this.surface = surface;
    this.highlightedLips.update(surface);
    if (!this.isDrawn && !this.mask.visible && !this.highlighted.isOn) {
      this.highlighted.object.visible = false;
      return;
    }
    if (mirror.topologyVersion !== this.shownVersion) {
      this.updateTopology();
      this.shownVersion = mirror.topologyVersion;
    }
    const { geometry } = this.mesh;
    const positions = geometry.getAttribute('position') as BufferAttribute;
    const normals = geometry.getAttribute('normal') as BufferAttribute;
    vertexNormals(
      mirror.positions,
      mirror.numVertices,
      mirror.triangles,
      mirror.numSlots,
      normals.array as Float32Array,
    );
    upload(positions, 3 * mirror.numVertices);
    upload(normals, 3 * mirror.numVertices);
    this.updateLips();
    this.highlighted.update(mirror, positions);
    if (this.wires.visible) this.updateWires();
  }

  private updateTopology(): void {
    const { mirror, locator } = this.surface!;
    const { geometry } = this.mesh;
    if (geometry.getAttribute('position')?.array !== mirror.positions) {
      geometry.dispose();
      this.wires.geometry.dispose();
      const positions = new BufferAttribute(mirror.positions, 3).setUsage(DynamicDrawUsage);
      geometry.setAttribute('position', positions);
      geometry.setAttribute(
        'normal',
        new BufferAttribute(new Float32Array(mirror.positions.length), 3).setUsage(DynamicDrawUsage),
      );
      this.wires.geometry.setAttribute('position', positions);
      this.wiresVersion = -1;
    }
    geometry.setAttribute('uv', new BufferAttribute(mirror.materialPositions.slice(0, 2 * mirror.numVertices), 2));
    this.updateIndex();
    const width = Math.max(locator.max.x - locator.min.x, locator.max.y - locator.min.y);
    if (width > 0) for (const cloth of this.cloths) cloth.setChecks(width / 10, locator.min);
  }

  private updateIndex(): void {
    const { mirror } = this.surface!;
    const { geometry } = this.mesh;
    const looks = this.looksOf(mirror);
    const index = new Uint32Array(3 * mirror.numSlots);
    geometry.clearGroups();
    let at = 0;
    for (let look = 0; look < (looks ? this.cloths.length : 1); ++look) {
      const first = at;
      for (let slot = 0; slot < mirror.numSlots; ++slot) {
        if (looks && looks[slot] !== look) continue;
        // An empty slot becomes a triangle without area.
        for (let corner = 3 * slot; corner < 3 * slot + 3; ++corner) index[at++] = Math.max(0, mirror.triangles[corner]);
      }
      if (at > first) geometry.addGroup(first, at - first, look);
    }
    geometry.setIndex(new BufferAttribute(index, 1));
  }

  private setOwnColors(isOn: boolean): void {
    this.hasOwnColors = isOn;
    for (const cloth of this.cloths) cloth.setOwnColors(isOn);
  }

  private updateLips(): void {
    const {
      mirror: { positions },
      boundary,
    } = this.surface!;
    const ends = this.lips.begin(boundary.length / 3);
    for (let i = 0, at = 0; i < boundary.length; i += 3) {
      for (let end = 0; end < 2; ++end) {
        const from = 3 * boundary[i + end];
        ends[at++] = positions[from];
        ends[at++] = positions[from + 1];
        ends[at++] = positions[from + 2];
      }
    }
  }

  private updateWires(): void {
    if (!this.surface || this.wiresVersion === this.shownVersion) return;
    const {
      mirror: { triangles, numSlots },
      boundary,
    } = this.surface;
    // Lists each edge once: the two triangles of an inner edge run along it in opposite directions; a border edge has
    // one triangle.
    const edges: number[] = [];
    for (let i = 0; i < 3 * numSlots; ++i) {
      const next = i % 3 === 2 ? i - 2 : i + 1;
      if (triangles[i] < triangles[next]) edges.push(triangles[i], triangles[next]);
    }
    for (let i = 0; i < boundary.length; i += 3) {
      if (boundary[i] > boundary[i + 1]) edges.push(boundary[i], boundary[i + 1]);
    }
    this.wires.geometry.setIndex(new BufferAttribute(Uint32Array.from(edges), 1));
    this.wiresVersion = this.shownVersion;
  }
}
