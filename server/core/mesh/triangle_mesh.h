#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/base/state_hash.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/mesh_data.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::mesh {

// Location of a lattice point in the welded mesh. For kFace and kEdge it does not depend on how it was found.
struct Location {
  enum class Kind { kOutside, kFace, kEdge, kPoint };
  Kind kind = Kind::kOutside;
  TriangleId triangle = kNone;  // kEdge: the lower of the two slots; kPoint: any with a corner there
  int corner = 0;               // kEdge: the edge opposite this corner; kPoint: the corner; kFace: no meaning
  PointId point = kNone;        // kPoint only
};

// Result of following a straight segment from one mesh point to another: the first point or fixed edge that it meets.
struct SegmentWalk {
  enum class Kind {
    kEdgeExists,  // the segment is itself an edge of the mesh: edge `corner` of `triangle`
    kPoint,       // passes through `point`, strictly between its ends
    kFixedEdge,   // crosses edge `corner` of `triangle`, which flips may not remove (see TriangleMesh::is_fixed)
    kClear,       // reaches its end across flippable edges only
  };
  Kind kind = Kind::kClear;
  TriangleId triangle = kNone;  // kFixedEdge: the slot on the side of the start
  int corner = 0;
  PointId point = kNone;
  std::vector<std::array<PointId, 2>> crossed;  // flippable edges crossed before, in order: {right end, left end}
};

// A triangle mesh in two-dimensional rest (material) space that stays welded there however often it is cut. Lips are
// locked edges. The opened mesh, which is simulated and shown, is only the map from triangle corners to vertices. So a
// cut along, across or into an older cut is no special case, and the two lips of a cut always match. Void triangles
// surround the sheet and fill its holes up to a square domain, so the fan of every point of the sheet is closed.
//
// Slots, points and vertices are never deleted and ids never reused, except that an undo removes the last ones. Where
// material is removed, slots become void and vertices stay behind without a triangle. A mesh as built has its solid
// triangles in slots 0..T-1 and its vertices 0..V-1, both in input order, the void slots after them.
//
// A plain value: a copy is an exact snapshot. All changes go through MeshEditor.
//
// Invariants (find_violation() names one that is broken):
//   I1  every index is in range; corners of a slot are three different points; counters agree
//   I2  adjacency is symmetric: neighbours share the two end points of the edge, in opposite order
//   I3  orient2d > 0, exactly, for every slot, void ones included
//   I4  locks are equal on both sides of an edge, and no lock that belongs to one edit is left
//   I5  an edge is border-locked if and only if one side is solid and the other void; cut-locked edges are solid on
//       both sides; an edge without neighbour is on the rim of the domain and void
//   I6  solid corners have vertices that lie at the corner's point; void corners have none
//   I7  vertices are equal across every edge that is solid on both sides and not cut
//   I8  each vertex has exactly one sector (one fan of solid triangles between two locked edges, or a closed one): no
//       vertex joins two sectors (no bow-tie in the opened mesh), and one in no triangle names none
//   I9  each point names a slot that has it as corner, and so does each vertex with material; other vertices name none
//   I10 no two points coincide, and the exact integer area of all slots is that of the domain: the tiling has neither
//       gap nor overlap
//   I11 pieces are the connected components of the opened mesh, numbered 0..num_pieces-1: flood fill and union-find
//       agree with the stored labels
//   I12 Euler: vertices - edges + triangles of the opened mesh = 2 pieces - boundary loops (each piece has genus 0);
//       vertices whose material was removed do not count
class TriangleMesh {
 public:
  TriangleMesh() = default;
  // Takes over records without checks. Call find_violation() afterwards if their origin is unknown.
  explicit TriangleMesh(MeshData data);

  // --- Sizes. Loop over slots t in [0, num_triangle_slots()) and skip those that are not solid.
  [[nodiscard]] std::int32_t num_vertices() const { return static_cast<std::int32_t>(data_.vertices.size()); }
  [[nodiscard]] std::int32_t num_points() const { return static_cast<std::int32_t>(data_.points.size()); }
  [[nodiscard]] std::int32_t num_triangle_slots() const { return static_cast<std::int32_t>(data_.triangles.size()); }
  [[nodiscard]] std::int32_t num_solid_triangles() const { return data_.num_solid_triangles; }
  [[nodiscard]] std::int32_t num_pieces() const { return data_.num_pieces; }

  // --- The opened mesh.
  [[nodiscard]] bool is_solid(TriangleId t) const { return record(t).region != kNone; }
  // Returns the vertices of a slot, counter-clockwise in material space; kNone in the void.
  [[nodiscard]] const std::array<VertexId, 3>& vertices(TriangleId t) const { return record(t).vertices; }
  // Returns the triangle across edge k (opposite corner k) in the opened mesh. Returns kNone on the border, on a lip
  // and in the void.
  [[nodiscard]] TriangleId neighbour(TriangleId t, int k) const {
    const TriangleRecord& r = record(t);
    return r.region == kNone || (r.locks[k] & kLocksThatOpen) != 0 ? kNone : r.neighbours[k];
  }
  // Returns the region of a slot: the label given at import, >= 0; kNone in the void.
  [[nodiscard]] std::int32_t region(TriangleId t) const {
    const Facet* const on = facet(t);
    return on != nullptr ? on->region : record(t).region;
  }
  // Returns the number of a slot's piece, in [0, num_pieces()); kNone in the void. If a piece is cut in two, one part
  // keeps its number.
  [[nodiscard]] std::int32_t piece(TriangleId t) const { return record(t).piece; }
  // Returns the material coordinates of v, m.
  [[nodiscard]] Eigen::Vector2d rest_position(VertexId v) const {
    return data_.lattice.position(data_.points[data_.vertices[v].point].at);
  }
  // Returns true if any triangle has a corner at v. Once the material around v was removed, only an undo makes it true
  // again.
  [[nodiscard]] bool has_material(VertexId v) const { return triangle_at(v) != kNone; }
  // Returns one solid triangle with a corner at v; kNone if v has no material.
  [[nodiscard]] TriangleId triangle_at(VertexId v) const { return data_.vertices[v].triangle; }
  // Fills `ring` with the triangles around v in counter-clockwise order. On the boundary it begins at the clockwise
  // end, inside at triangle_at(v). It is empty without material. O(degree).
  void triangles_around(VertexId v, std::vector<TriangleId>& ring) const;

  // --- Sizes in rest space.
  // Bounding box of the sheet as built, m.
  [[nodiscard]] const Eigen::AlignedBox2d& bounding_box() const { return data_.bounds; }
  // Returns the rest area, m^2, > 0. If the rest shape is curved, this is the area on the surface for solid triangles.
  [[nodiscard]] double area(TriangleId t) const;
  // Returns the area in the material plane, m^2, > 0, also of void slots.
  [[nodiscard]] double material_area(TriangleId t) const;
  // Returns the mean edge length of the mesh as built, m: the mean of sqrt(2 area) over its solid triangles. This is
  // the leg of an isosceles right triangle of that area. Cuts do not change it.
  [[nodiscard]] double base_edge_length() const { return data_.lengths.mean; }
  // Returns the local edge lengths of the mesh as built. Cuts do not change them.
  [[nodiscard]] const EdgeLengths& edge_lengths() const { return data_.lengths; }

  // --- A curved rest shape: material coordinates are then a chart of it. Lengths of cuts and edge_lengths() are
  // lengths in that chart.
  [[nodiscard]] bool is_curved() const { return data_.surface != nullptr; }
  // Returns true if both rest shapes are flat, or both are curved with equal facets.
  [[nodiscard]] bool has_surface_of(const TriangleMesh& other) const;
  // Returns the facet that a solid triangle is part of; null if the rest shape is flat, and in the void.
  [[nodiscard]] const Facet* facet(TriangleId t) const {
    return is_curved() && is_solid(t) ? &data_.surface->facets[static_cast<std::size_t>(record(t).region)] : nullptr;
  }
  // Returns the rest edges of a solid triangle from corner 0 to corners 1 and 2 as columns, m. They are in coordinates
  // of its own plane, whose first axis is along material x. Computed from lattice coordinates, whose differences are
  // exact; differences of positions are not if the sheet lies far from the origin.
  [[nodiscard]] Eigen::Matrix2d rest_edges(TriangleId t) const;
  // Maps a vector of the material plane (any unit) to the rest plane of slot t, as for rest_edges(). Returns it
  // unchanged if the rest shape is flat or t is void.
  [[nodiscard]] Eigen::Vector2d at_rest(TriangleId t, const Eigen::Vector2d& vector) const {
    const Facet* const on = facet(t);
    return on != nullptr ? Eigen::Vector2d(on->stretch() * vector) : vector;
  }
  // Returns true if p lies strictly inside the circumcircle of t, measured in the rest plane of t continued beyond it.
  // Exact if the rest shape is flat. If it is curved, p must be inside by more than rounding, so that flips end.
  [[nodiscard]] bool is_in_circle(TriangleId t, const LatticePoint& p) const;

  // --- The welded mesh (for cutting and checking).
  [[nodiscard]] const Lattice& lattice() const { return data_.lattice; }
  [[nodiscard]] const TriangleRecord& record(TriangleId t) const { return data_.triangles[t]; }
  [[nodiscard]] const MeshData& data() const { return data_; }
  [[nodiscard]] const std::array<PointId, 3>& points(TriangleId t) const { return record(t).points; }
  [[nodiscard]] const LatticePoint& at(PointId p) const { return data_.points[p].at; }
  [[nodiscard]] Eigen::Vector2d point_position(PointId p) const { return data_.lattice.position(at(p)); }  // m
  // Returns one slot with a corner at p.
  [[nodiscard]] TriangleId triangle_at_point(PointId p) const { return data_.points[p].triangle; }
  [[nodiscard]] PointId point(VertexId v) const { return data_.vertices[v].point; }
  // Returns the slot across edge k, whatever its locks; kNone at the rim of the domain only.
  [[nodiscard]] TriangleId welded_neighbour(TriangleId t, int k) const { return record(t).neighbours[k]; }
  [[nodiscard]] LockBits locks(TriangleId t, int k) const { return record(t).locks[k]; }
  // Returns true if flips may not remove edge k: it is locked, on the rim of the domain, or between two regions.
  [[nodiscard]] bool is_fixed(TriangleId t, int k) const {
    const TriangleRecord& r = record(t);
    return r.locks[k] != 0 || r.neighbours[k] == kNone || record(r.neighbours[k]).region != r.region;
  }
  // Returns the corner (0 to 2) of t at point p, or kNone.
  [[nodiscard]] int corner_of(TriangleId t, PointId p) const {
    const std::array<PointId, 3>& corners = points(t);  // a sum, since branches would be mispredicted
    return kNone + (corners[0] == p ? 1 : 0) + (corners[1] == p ? 2 : 0) + (corners[2] == p ? 3 : 0);
  }
  // Returns the corner of welded_neighbour(t, k) that is opposite edge k.
  [[nodiscard]] int mirror_corner(TriangleId t, int k) const {
    return previous_corner(corner_of(welded_neighbour(t, k), points(t)[previous_corner(k)]));
  }
  // Fills `fan` with all slots around p, void ones too, in counter-clockwise order. The fan is closed except at the
  // four corners of the domain. O(degree).
  void fan_around(PointId p, std::vector<TriangleId>& fan) const;
  // Returns the union of the locks of all edges at p. O(degree).
  [[nodiscard]] LockBits locks_at_point(PointId p) const;
  // Returns true if any edge at p is fixed. O(degree).
  [[nodiscard]] bool has_fixed_edge(PointId p) const;
  // Finds the edge between p and q. Returns the slot that has p before q in counter-clockwise order, and sets `corner`
  // to the corner opposite the edge. Returns kNone if there is no such edge. O(degree of p).
  [[nodiscard]] TriangleId find_edge(PointId p, PointId q, int& corner) const;

  // Locates p by walking from slot to slot (Devillers, Pion, Teillaud 2001, "Walking in a triangulation"; see
  // walk_to()). `hint`: a slot near p, or kNone to start from a coarse grid.
  [[nodiscard]] Location locate(const LatticePoint& p, TriangleId hint = kNone) const;

  // Follows the segment from point p to point q != p until it meets a point or a fixed edge, or reaches q.
  [[nodiscard]] SegmentWalk walk_segment(PointId p, PointId q) const;

  // --- Whole-mesh checks.
  // Returns the number of closed chains of edges without neighbour in the opened mesh: borders and lips. O(n).
  [[nodiscard]] std::int32_t num_boundary_loops() const;
  // Adds everything that two meshes must have in common to behave identically from now on.
  void add_to(StateHash& hash) const;
  [[nodiscard]] std::uint64_t state_hash() const;
  // Returns a broken invariant in words, or nothing. O(n log n). Called by tests, fuzzers and KERF_VALIDATE builds.
  [[nodiscard]] std::optional<std::string> find_violation() const;
  friend bool operator==(const TriangleMesh& a, const TriangleMesh& b);

 private:
  friend struct Fields<TriangleMesh>;
  friend class MeshEditor;
  friend struct UndoLog;

  [[nodiscard]] TriangleId hint_near(const LatticePoint& p) const;
  void build_hints();

  MeshData data_;
  // A coarse grid of slots to start walks from: for each cell, a slot that lay there when the mesh was built. It is
  // only a hint, so not part of the state.
  std::vector<TriangleId> hints_;
  std::int32_t hint_columns_ = 0;
  std::int32_t hint_rows_ = 0;
};

}  // namespace kerf::mesh
