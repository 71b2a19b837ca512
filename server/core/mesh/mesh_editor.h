#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "server/core/mesh/id_map.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Everything needed to take back one committed edit: old sizes, and each old record that was overwritten.
struct UndoLog {
  std::int32_t num_points = 0;
  std::int32_t num_vertices = 0;
  std::int32_t num_triangle_slots = 0;
  std::int32_t num_solid_triangles = 0;
  std::int32_t num_pieces = 0;
  std::vector<std::pair<PointId, PointRecord>> points;           // each id once
  std::vector<std::pair<VertexId, VertexRecord>> vertices;       // each id once
  std::vector<std::pair<TriangleId, TriangleRecord>> triangles;  // each id once
  std::int32_t num_points_after = 0;                             // sizes after the edit, to catch an undo out of order
  std::int32_t num_vertices_after = 0;
  std::int32_t num_triangle_slots_after = 0;

  // Restores `mesh` bit for bit to what it was before the edit, which must be the last one not yet undone. O(touched).
  void undo(TriangleMesh& mesh) const;

  // The log that takes this one back: made of `mesh` as the edit left it, its undo() makes the edit again, bit for bit,
  // once this one has been undone. O(touched).
  [[nodiscard]] UndoLog inverse(const TriangleMesh& mesh) const;

 private:
  friend class MeshEditor;
  void restore(TriangleMesh& mesh) const;
};

struct CommittedEdit {
  MeshEdit edit;
  UndoLog undo;
};

// Outcome of an attempt to recover an edge.
struct Recovery {
  enum class Status {
    kRecovered,  // edge `corner` of `triangle` joins the two points now
    kPoint,      // `point` lies strictly between the two; recover the parts
    kFixedEdge,  // edge `corner` of `triangle` is crossed and may not be flipped: split it first
    kLimit,      // the flip counter ran out: give the edit up (never seen; the counter is there to be certain)
  };
  Status status = Status::kLimit;
  TriangleId triangle = kNone;
  int corner = 0;
  PointId point = kNone;
};

// One edit of a mesh, whole or not at all: operations, then commit(); rollback() or destruction without commit restores
// the mesh bit for bit. All operations keep invariants I1-I5, I9 and I10 at every step; the corner -> vertex map and
// the pieces are brought up to date by open() (until then new points have no vertex: kNone in solid corners).
//
// Splits and flips rewrite slots in place: see each operation. Only move_point moves points.
class MeshEditor {
 public:
  static constexpr std::int32_t kDefaultMaxSlots = 4'000'000;
  // Least distance (lattice units) of a new point from a locked edge of its triangle; split_triangle refuses a closer
  // one. Once that edge is split and rounded, a closer point could not be distinguished from a point on it.
  static constexpr std::int64_t kLockClearance = 16;

  // `max_triangle_slots`: the element budget; an operation that would go beyond it changes nothing and fails.
  explicit MeshEditor(TriangleMesh& mesh, std::int32_t max_triangle_slots = kDefaultMaxSlots);
  ~MeshEditor();
  MeshEditor(const MeshEditor&) = delete;
  MeshEditor& operator=(const MeshEditor&) = delete;

  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  // Returns true if an operation failed because no slots were left.
  [[nodiscard]] bool budget_exhausted() const { return budget_exhausted_; }
  [[nodiscard]] bool is_new(PointId p) const { return p >= log_.num_points; }

  // Inserts p strictly inside t:
  //
  //        2                 2
  //       / \               /|\       slot t keeps edge 0 (1-2), two new slots get edges 1 and 2;
  //      / p \      ->     / p \      region, piece, outer locks and corner vertices are kept
  //     0-----1           0-----1
  //
  // Returns the new point, or kNone (nothing changed): p is not strictly inside, is closer than kLockClearance to a
  // locked edge of t, or the budget is exhausted.
  PointId split_triangle(TriangleId t, const LatticePoint& p);

  // Inserts p on, or within rounding of, edge k of t; u = welded_neighbour(t, k):
  //
  //        k                 k
  //       /t\               /|\       t and u keep their corner k+1 of t, two new slots get the corner k+2 of t;
  //      a---b      ->     a-p-b      both halves inherit the locks of the edge
  //       \u/               \|/
  //        m                 m
  //
  // p need not lie on the edge exactly: it is enough that all four new triangles are strictly positive. Returns the
  // new point, or kNone (nothing changed): one would not be, the edge is on the rim, or the budget is exhausted.
  PointId split_edge(TriangleId t, int k, const LatticePoint& p);

  // Inserts p where it lies: by split_triangle, by split_edge, or not at all if a point is there already (returned as
  // it is). Returns kNone where these do, or if p is outside the domain.
  PointId insert_point(const LatticePoint& p, TriangleId hint = kNone);

  // Swaps the diagonal of the quad around edge k of t; u = welded_neighbour(t, k):
  //
  //        k                 k
  //       /t\               /|\       slot t becomes (k, a, m), slot u becomes (m, b, k);
  //      a---b      ->     a | b      outer locks and all corner vertices travel along
  //       \u/               \|/
  //        m                 m
  //
  // Returns false (nothing changed) if the edge is fixed or the quad is not strictly convex. On success the new edge is
  // the edge opposite the corner a in t, whichever number that has.
  bool flip_edge(TriangleId t, int k);

  // Adds lock bits to edge k of t on both sides. kLockCut also sets kLockFresh where the edge was not cut yet. Returns
  // false, and changes nothing, for kLockCut on an edge that is not solid on both sides (a border is open already).
  bool lock_edge(TriangleId t, int k, LockBits bits);

  // Makes solid slots void: they lose region, piece and vertices. Where they meet solid ones the edges become border,
  // where they meet the void they are unlocked. Each edge between a slot removed and a solid one that stays must be
  // locked already. open() removes vertices and pieces left without a triangle; it must not have been called before. At
  // least one solid slot must stay.
  void remove_triangles(const std::vector<TriangleId>& slots);

  // Moves p, which must exist already, to `to`. Returns false (nothing changed) if p is on a locked edge, on an edge
  // between regions or on the rim. It does the same if a triangle of its star would not stay strictly positive.
  bool move_point(PointId p, const LatticePoint& to);

  // Lawson flips around p until every quad that p is a corner of is locally Delaunay or its edge is fixed. Cocircular
  // quads are left alone, so an untouched regular grid stays as it is. Returns the number of flips.
  int legalise(PointId p);

  // Makes edge pq by flips (Sloan 1993, "A fast algorithm for generating constrained Delaunay triangulations"). Adds
  // `locks`, if any, as lock_edge does. Then flips those of the edges made on the way that are not locally Delaunay. On
  // failure some flips may have been done; they are valid, and rolled back with the edit.
  Recovery recover_edge(PointId p, PointId q, LockBits locks);

  // Brings the corner -> vertex map up to date at new points and at the ends of freshly cut edges: one vertex for each
  // connected sector of solid triangles around a point. Of the sectors that shared a vertex, the one with the lowest
  // slot keeps it. Then renumbers pieces. All parts of a piece are flood-filled at once (see piece_split.h); the last
  // one, whose fill is not completed, keeps the piece's number. A piece without material gives up its number, which the
  // piece with the highest number takes. May be called more than once; commit() calls it for the remaining changes.
  void open();

  // Ends the edit. Locks that belong to one edit are cleared. Weights in the record are barycentric in the triangle of
  // the mesh before the edit that holds the vertex's final position. On an edge that was locked before, the vertices of
  // each side use the two old vertices of that side. A copy of an old vertex that did not move has weight 1 on it. Call
  // once.
  CommittedEdit commit();

  // Restores the mesh to what it was before the edit, sizes included.
  void rollback();

 private:
  // Names an edge that was locked before the edit and that holds a new point. It is given by a slot of the mesh before
  // the edit and the corner opposite.
  struct Lip {
    TriangleId triangle = kNone;  // kNone: the point is not on such an edge
    int corner = 0;
  };
  // Ancestry of a new vertex, known when it is made; weights follow at commit, from final positions.
  struct NewVertex {
    VertexId vertex = kNone;
    VertexId origin = kNone;  // vertex before the edit at the same point, or kNone for a new point
    Lip lip;                  // on the side of the vertex's sector
  };
  // A maximal run of solid triangles around a point that no lock separates.
  struct Sector {
    std::size_t begin = 0, end = 0;  // in the fan around the point, counter-clockwise
    TriangleId lowest = kNone;
    Lip lip;
  };

  TriangleRecord& touch_triangle(TriangleId t);
  PointRecord& touch_point(PointId p);
  VertexRecord& touch_vertex(VertexId v);
  TriangleId add_slot(const TriangleRecord& record, TriangleId parent);
  PointId add_point(const LatticePoint& p);
  bool take_slots(std::int32_t count);
  void relink(TriangleId t, TriangleId from, TriangleId to);
  void move_representative(TriangleId from, TriangleId to, PointId p, VertexId v);
  [[nodiscard]] bool respects_clearance(TriangleId t, const LatticePoint& p, int skipped_edge) const;
  [[nodiscard]] Lip lip_of_edge(TriangleId t, int k) const;
  [[nodiscard]] Lip across(const Lip& lip) const;

  using Edge = std::array<PointId, 2>;
  bool flip_crossed_edges(PointId p, PointId q, const std::vector<Edge>& crossed, std::vector<Edge>& made);
  void legalise_edges(std::vector<Edge>& edges);

  void open_point(PointId p);
  // Sorted by `lowest`. Replaces the contents of `fan`.
  [[nodiscard]] std::vector<Sector> sectors_around(PointId p, std::vector<TriangleId>& fan) const;
  [[nodiscard]] std::vector<bool> left_of_lip(PointId p, const Lip& lip, const std::vector<TriangleId>& fan) const;
  void add_vertex(PointId p, const Sector& sector, VertexId held);
  void drop_orphaned_vertices();
  void label_pieces();
  void label_split_pieces(const std::vector<TriangleId>& seeds);
  void drop_orphaned_pieces(const std::vector<TriangleId>& seeds);

  [[nodiscard]] const TriangleRecord& old_record(TriangleId t) const;
  [[nodiscard]] const LatticePoint& old_at(PointId p) const;
  [[nodiscard]] bool is_moved(PointId p) const { return !is_new(p) && old_at(p) != mesh_.at(p); }
  [[nodiscard]] TriangleId parent_of(TriangleId t) const;
  [[nodiscard]] Lip old_edge(TriangleId t, int k) const;
  [[nodiscard]] TriangleId locate_in_old(const LatticePoint& p, TriangleId start) const;
  [[nodiscard]] VertexSource source_of(const NewVertex& added) const;
  [[nodiscard]] VertexSource interpolate(VertexId v) const;
  [[nodiscard]] VertexSource interpolate_on_lip(VertexId v, const Lip& lip) const;
  [[nodiscard]] std::vector<VertexSource> moved_sources() const;
  [[nodiscard]] std::vector<TriangleId> rewritten_triangles() const;
  void clear_edit_locks();

  TriangleMesh& mesh_;
  UndoLog log_;
  std::int32_t max_slots_;
  bool budget_exhausted_ = false;
  bool finished_ = false;
  // Positions of their entries in the log.
  IdMap triangle_entry_, point_entry_, vertex_entry_;
  std::vector<TriangleId> parents_;       // of new slots: the slot before the edit that they were split from
  std::vector<Lip> lips_;                 // of new points
  std::vector<PointId> pending_;          // points to open, may repeat
  std::vector<PointId> moved_;            // old points that move_point was called on, may repeat
  std::vector<NewVertex> new_vertices_;   // by VertexId - log_.num_vertices
  std::vector<std::int32_t> split_from_;  // see MeshEdit
  // Vertices and pieces of removed slots, in any order, repeated; then those left without material, see MeshEdit.
  std::vector<VertexId> orphaned_vertices_;
  std::vector<std::int32_t> orphaned_pieces_;
  std::vector<VertexId> removed_vertices_;
  std::vector<std::int32_t> removed_pieces_;
};

}  // namespace kerf::mesh
