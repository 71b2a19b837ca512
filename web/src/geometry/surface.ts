import { Vector2, Vector3 } from 'three';
import type { Camera, Ray } from 'three';
import type { SheetArrays } from '../stream/sheet_copy';
import { boundaryEdges } from './boundary';
import { Locator } from './locator';
import type { Place, Point2 } from './locator';

export interface Hit {
  /** world, metres */
  world: Vector3;
  /** metres */
  material: Point2;
  /** Vertex of the hit triangle with the largest weight at the hit. */
  vertex: number;
}

// A click beside the sheet counts as a point there up to this distance from the border, in CSS pixels.
const kReachPx = 160;

/**
 * The sheet as a surface in world and material coordinates. Finds the places of rays and material points on the current
 * mesh.
 */
export class Surface {
  private locatorVersion = -1;
  private cachedLocator: Locator | undefined;
  private boundaryVersion = -1;
  private cachedBoundary: Uint32Array = new Uint32Array(0);

  private materialVersion = -1;
  private cachedMaterial = new Uint8Array(0);

  constructor(readonly mirror: SheetArrays) {}

  /**
   * True if a triangle has this vertex. Cuts with a width leave vertices without triangles, whose positions mean
   * nothing.
   */
  hasMaterial(vertex: number): boolean {
    const { mirror } = this;
    if (this.materialVersion !== mirror.topologyVersion) {
      this.cachedMaterial = new Uint8Array(mirror.numVertices);
      for (let i = 0; i < 3 * mirror.numSlots; ++i) {
        if (mirror.triangles[i] >= 0) this.cachedMaterial[mirror.triangles[i]] = 1;
      }
      this.materialVersion = mirror.topologyVersion;
    }
    return this.cachedMaterial[vertex] === 1;
  }

  /** Returns this vertex, or if it has no material any more, the nearest one on the undeformed sheet that has. */
  nearestWithMaterial(vertex: number): number {
    if (this.hasMaterial(vertex)) return vertex;
    const { numVertices, materialPositions: m } = this.mirror;
    let nearest = vertex;
    let least = Infinity;
    for (let v = 0; v < numVertices; ++v) {
      const distance = (m[2 * v] - m[2 * vertex]) ** 2 + (m[2 * v + 1] - m[2 * vertex + 1]) ** 2;
      if (distance < least && this.hasMaterial(v)) [nearest, least] = [v, distance];
    }
    return nearest;
  }

  /** Start vertex, end vertex and slot of each border or lip edge; see boundaryEdges(). */
  get boundary(): Uint32Array {
    const { mirror } = this;
    if (this.boundaryVersion !== mirror.topologyVersion) {
      this.cachedBoundary = boundaryEdges(mirror.triangles, mirror.numSlots, mirror.numVertices);
      this.boundaryVersion = mirror.topologyVersion;
    }
    return this.cachedBoundary;
  }

  get locator(): Locator {
    const { mirror } = this;
    if (!this.cachedLocator || this.locatorVersion !== mirror.topologyVersion) {
      this.cachedLocator = new Locator(mirror.materialPositions, mirror.numVertices, mirror.triangles, mirror.numSlots);
      this.locatorVersion = mirror.topologyVersion;
    }
    return this.cachedLocator;
  }

  vertexPosition(vertex: number, out = new Vector3()): Vector3 {
    return out.fromArray(this.mirror.positions, 3 * vertex);
  }

  /** Returns the first point where the ray meets a triangle, from either side. */
  pick(ray: Ray): Hit | undefined {
    const place = this.firstOnRay(ray.origin, ray.direction);
    if (!place) return undefined;
    const weights = [1 - place.u - place.v, place.u, place.v];
    const nearest = weights.indexOf(Math.max(...weights));
    return {
      world: this.worldAt(place),
      material: this.materialAt(place),
      vertex: this.mirror.triangles[3 * place.slot + nearest],
    };
  }

  /**
   * Returns a material point for a click beside the sheet, so that a cut can begin and end off the sheet. It is as far
   * outside the nearest border edge as the click is. Undefined far from any border.
   */
  pickBeside(
    pointPx: Vector2,
    camera: Camera,
    sizePx: Vector2,
    metresPerPx: (at: Vector3) => number,
  ): Point2 | undefined {
    const { mirror, boundary } = this;
    const toPx = (vertex: number): Vector2 => {
      const p = this.vertexPosition(vertex).project(camera);
      return new Vector2((0.5 + 0.5 * p.x) * sizePx.x, (0.5 - 0.5 * p.y) * sizePx.y);
    };
    let best = { distance: kReachPx, edge: -1, t: 0 };
    for (let edge = 0; edge < boundary.length; edge += 3) {
      const start = toPx(boundary[edge]);
      const along = toPx(boundary[edge + 1]).sub(start);
      const t = Math.min(1, Math.max(0, pointPx.clone().sub(start).dot(along) / (along.lengthSq() || 1)));
      const distance = pointPx.distanceTo(start.addScaledVector(along, t));
      if (distance < best.distance) best = { distance, edge, t };
    }
    if (best.edge < 0) return undefined;
    const [a, b] = [boundary[best.edge], boundary[best.edge + 1]];
    const m = mirror.materialPositions;
    const direction = new Vector2(m[2 * b] - m[2 * a], m[2 * b + 1] - m[2 * a + 1]);
    const outward = new Vector2(direction.y, -direction.x).normalize();
    const at = this.vertexPosition(a).lerp(this.vertexPosition(b), best.t);
    const reach = best.distance * metresPerPx(at);
    return {
      x: m[2 * a] + best.t * direction.x + reach * outward.x,
      y: m[2 * a + 1] + best.t * direction.y + reach * outward.y,
    };
  }

  /**
   * Returns the world position of a material point; a point beside the sheet lies in the plane of the triangle at the
   * nearest border edge.
   */
  toWorld(point: Point2): Vector3 | undefined {
    const place = this.placeOf(point);
    return place && this.worldAt(place);
  }

  /** Returns the world position of a material point that lies in a triangle; else undefined. */
  onSheet(point: Point2): Vector3 | undefined {
    const place = this.locator.find(point);
    return place && this.worldAt(place);
  }

  /** Returns the place of a material point; beside the sheet its weights are outside 0..1. */
  placeOf(point: Point2): Place | undefined {
    return this.locator.find(point) ?? this.nearestOnBoundary(point);
  }

  private materialAt(place: Place): Point2 {
    const { triangles, materialPositions: m } = this.mirror;
    const [a, b, c] = [0, 1, 2].map((corner) => 2 * triangles[3 * place.slot + corner]);
    const w = 1 - place.u - place.v;
    return { x: w * m[a] + place.u * m[b] + place.v * m[c], y: w * m[a + 1] + place.u * m[b + 1] + place.v * m[c + 1] };
  }

  private worldAt(place: Place): Vector3 {
    const { triangles } = this.mirror;
    const first = 3 * place.slot;
    return this.vertexPosition(triangles[first])
      .multiplyScalar(1 - place.u - place.v)
      .addScaledVector(this.vertexPosition(triangles[first + 1]), place.u)
      .addScaledVector(this.vertexPosition(triangles[first + 2]), place.v);
  }

  // Returns the triangle at the border edge nearest to the point, and the point's weights in it, some outside 0..1.
  private nearestOnBoundary(point: Point2): Place | undefined {
    const { boundary } = this;
    const { materialPositions: m } = this.mirror;
    let nearest = Infinity;
    let slot = -1;
    for (let i = 0; i < boundary.length; i += 3) {
      const [a, b] = [2 * boundary[i], 2 * boundary[i + 1]];
      const [dx, dy] = [m[b] - m[a], m[b + 1] - m[a + 1]];
      const along = ((point.x - m[a]) * dx + (point.y - m[a + 1]) * dy) / (dx * dx + dy * dy || 1);
      const t = Math.min(1, Math.max(0, along));
      const square = (point.x - m[a] - t * dx) ** 2 + (point.y - m[a + 1] - t * dy) ** 2;
      if (square >= nearest) continue;
      nearest = square;
      slot = boundary[i + 2];
    }
    return slot < 0 ? undefined : this.locator.placeIn(slot, point);
  }

  // Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), over all triangles. It runs per
  // click or pointer move, not per frame, so it needs no acceleration structure that follows the moving mesh.
  private firstOnRay(origin: Vector3, direction: Vector3): Place | undefined {
    const { positions: x, triangles, numSlots } = this.mirror;
    const { x: dx, y: dy, z: dz } = direction;
    let nearest = Infinity;
    let place: Place | undefined;
    for (let slot = 0; slot < numSlots; ++slot) {
      const a = 3 * triangles[3 * slot];
      if (a < 0) continue;
      const b = 3 * triangles[3 * slot + 1];
      const c = 3 * triangles[3 * slot + 2];
      const abX = x[b] - x[a],
        abY = x[b + 1] - x[a + 1],
        abZ = x[b + 2] - x[a + 2];
      const acX = x[c] - x[a],
        acY = x[c + 1] - x[a + 1],
        acZ = x[c + 2] - x[a + 2];
      const pX = dy * acZ - dz * acY,
        pY = dz * acX - dx * acZ,
        pZ = dx * acY - dy * acX;
      const determinant = abX * pX + abY * pY + abZ * pZ;
      if (determinant === 0) continue;
      const tX = origin.x - x[a],
        tY = origin.y - x[a + 1],
        tZ = origin.z - x[a + 2];
      const u = (tX * pX + tY * pY + tZ * pZ) / determinant;
      if (u < 0 || u > 1) continue;
      const qX = tY * abZ - tZ * abY,
        qY = tZ * abX - tX * abZ,
        qZ = tX * abY - tY * abX;
      const v = (dx * qX + dy * qY + dz * qZ) / determinant;
      if (v < 0 || u + v > 1) continue;
      const distance = (acX * qX + acY * qY + acZ * qZ) / determinant;
      if (distance > 0 && distance < nearest) {
        nearest = distance;
        place = { slot, u, v };
      }
    }
    return place;
  }
}
