#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "server/core/mesh/id_map.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Everything needed to undo one committed edit: the old sizes, and the old value of each record that was overwritten.
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

  // Restores `mesh` bit for bit to its state before the edit. The edit must be the last one that is not undone yet.
  // Costs O(records touched by the edit).
  void undo(TriangleMesh& mesh) const;

  // Returns a log for redo. `mesh` must be in the state that the edit left. Once this log has been undone, undo() of
  // the returned log makes the edit again, bit for bit. Costs O(records touched by the edit).
  [[nodiscard]] UndoLog inverse(const TriangleMesh& mesh) const;

 private:
  friend class MeshEditor;
  void restore(TriangleMesh& mesh) const;
};

struct CommittedEdit {
  MeshEdit edit;
  UndoLog undo;
};

// Outcome of an attempt to make the segment between two points an edge by flips.
struct Recovery {
  enum class Status {
    kRecovered,  // edge `corner` of `triangle` joins the two points now
    kPoint,      // `point` lies strictly between the two points; recover the two parts
    kFixedEdge,  // edge `corner` of `triangle` is crossed and may not be flipped: split it first
    kLimit,      // too many flips: give up the edit (never seen; the limit guarantees an end)
  };
  Status status = Status::kLimit;
  TriangleId triangle = kNone;
  int corner = 0;
  PointId point = kNone;
};

// One edit of a mesh, made as a whole or not at all. Call operations, then commit(). rollback(), or destruction without
// commit(), restores the mesh bit for bit. All operations keep invariants I1-I5, I9 and I10 of TriangleMesh at every
// step. open() updates the vertices of corners and the pieces; until then new points have no vertex (kNone in solid
// corners).
//
// Splits and flips reuse the slots of the old triangles: see each operation. Only move_point moves points.
class MeshEditor {
 public:
  static constexpr std::int32_t kDefaultMaxSlots = 4'000'000;
  // Least distance (lattice units) of a new point from a locked edge of its triangle; split_triangle refuses a closer
  // one. After a split of that edge and rounding, a closer point might lie on the edge.
  static constexpr std::int64_t kLockClearance = 16;

  // `max_triangle_slots`: most slots of the mesh. An operation that would need more changes nothing and fails.
  explicit MeshEditor(TriangleMesh& mesh, std::int32_t max_triangle_slots = kDefaultMaxSlots);
  ~MeshEditor();
  MeshEditor(const MeshEditor&) = delete;
  MeshEditor& operator=(const MeshEditor&) = delete;

  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  // Returns true if an operation failed because it needed more slots than max_triangle_slots.
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
  // locked edge of t, or no slots are left.
  PointId split_triangle(TriangleId t, const LatticePoint& p);

  // p need not lie on the edge exactly, but all four new triangles must be strictly positive. Returns the new point.
  // Returns kNone and changes nothing if they are not positive or no slots are left. Does the same if the edge is on
  // the rim of the domain, or p is closer than kLockClearance to another locked edge.
  PointId split_edge(TriangleId t, int k, const LatticePoint& p);

  // Inserts p by split_triangle or split_edge, depending on where it lies. Returns a point that is already there as it
  // is. Returns kNone if the split fails, or if p is outside the domain. `hint`: a slot near p, or kNone.
  PointId insert_point(const LatticePoint& p, TriangleId hint = kNone);

  // Swaps the diagonal of the quad around edge k of t; u = welded_neighbour(t, k):
  //
  //        k                 k
  //       /t\               /|\       slot t becomes (k, a, m), slot u becomes (m, b, k);
  //      a---b      ->     a | b      outer locks and all corner vertices travel along
  //       \u/               \|/
  //        m                 m
  //
  // Returns false and changes nothing if the edge is fixed or the quad is not strictly convex. On success the new edge
  // is that of t opposite a; the number of corner a in t stays the same.
  bool flip_edge(TriangleId t, int k);

  // Adds lock bits to edge k of t, on both sides. kLockCut also sets kLockFresh if the edge was not cut yet. Returns
  // false and changes nothing for kLockCut on an edge that is not solid on both sides: a border is open already.
  bool lock_edge(TriangleId t, int k, LockBits bits);

  // Makes solid slots void: they lose region, piece and vertices. Edges to solid slots that stay become border; they
  // must be locked already. Edges to void slots are unlocked. Must be called before open(), which removes the vertices
  // and pieces that are left without a triangle. At least one solid slot must stay.
  void remove_triangles(const std::vector<TriangleId>& slots);

  // Moves the point p to `to`. Returns false and changes nothing if an edge at p is fixed (see TriangleMesh::is_fixed).
  // Does the same if a triangle around p would not stay strictly positive, or p would come within kLockClearance of a
  // locked edge.
  bool move_point(PointId p, const LatticePoint& to);

  // Flips edges around p (Lawson's method) until all edges opposite p are fixed or locally Delaunay. Four points on one
  // circle count as Delaunay, so an untouched regular grid stays as it is. Returns the number of flips.
  int legalise(PointId p);

  // Makes the segment pq an edge by flips (Sloan 1993, "A fast algorithm for generating constrained Delaunay
  // triangulations"). Adds `locks`, if any, as lock_edge does. Then makes the other edges that these flips created
  // locally Delaunay. Some flips may remain after a failure; they are valid.
  Recovery recover_edge(PointId p, PointId q, LockBits locks);

  // Updates the vertices of corners at new points and at the ends of freshly cut edges. Each connected sector of solid
  // triangles around a point gets one vertex. If several sectors shared a vertex, the sector with the lowest slot keeps
  // it. Then renumbers pieces. All parts of a piece are flood-filled at once (see piece_split.h); the last one, whose
  // fill is not completed, keeps the piece's number. A piece without material gives up its number, which the piece with
  // the highest number takes. May be called more than once; commit() calls it for the remaining changes.
  void open();

  // Ends the edit. Locks that belong to one edit are cleared. The record gives each new or moved vertex weights on old
  // vertices. They are barycentric in the triangle, before the edit, that holds the vertex's final position. A vertex
  // on an edge locked before the edit uses the two old vertices on its own side of that edge. A copy of an old vertex
  // that did not move has weight 1 on that vertex. Call once.
  CommittedEdit commit();

  // Restores the mesh to what it was before the edit, sizes included.
  void rollback();

 private:
  // An edge of the mesh before the edit that was locked and holds a new point. It is named by a slot of that mesh and
  // the corner opposite.
  struct Lip {
    TriangleId triangle = kNone;  // kNone: the point is not on such an edge
    int corner = 0;
  };
  // The origin of a new vertex, recorded when the vertex is made. commit() computes its weights from final positions.
  struct NewVertex {
    VertexId vertex = kNone;
    VertexId origin = kNone;  // vertex before the edit at the same point, or kNone for a new point
    Lip lip;                  // the locked edge it lies on, seen from the vertex's side
  };
  // A maximal run of solid triangles around a point that no lock separates.
  struct Sector {
    std::size_t begin = 0, end = 0;  // range in the fan around the point, counter-clockwise
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
  // Returns the sectors around p, sorted by `lowest`. Replaces the contents of `fan` by the triangles around p.
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
  // For each touched old record, the index of its entry in log_.
  IdMap triangle_entry_, point_entry_, vertex_entry_;
  std::vector<TriangleId> parents_;       // for each new slot: the slot before the edit that it was split from
  std::vector<Lip> lips_;                 // for each new point
  std::vector<PointId> pending_;          // points whose vertices open() must update, may repeat
  std::vector<PointId> moved_;            // old points that move_point was called on, may repeat
  std::vector<NewVertex> new_vertices_;   // by VertexId - log_.num_vertices
  std::vector<std::int32_t> split_from_;  // see MeshEdit
  // Vertices and pieces of slots that were made void, in any order, may repeat.
  std::vector<VertexId> orphaned_vertices_;
  std::vector<std::int32_t> orphaned_pieces_;
  std::vector<VertexId> removed_vertices_;
  std::vector<std::int32_t> removed_pieces_;
};

}  // namespace kerf::mesh
