#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/cut/lip_trace.h"
#include "server/core/cut/path_scale.h"
#include "server/core/cut/path_walk.h"
#include "server/core/cut/strip.h"
#include "server/core/mesh/mesh_editor.h"

namespace kerf::cut {

// Counts of an insertion; lengths in lattice units.
struct InsertionCounts {
  std::int32_t new_lip_edges = 0;
  std::int32_t snapped_points = 0;
  std::int32_t closed_gaps = 0;
  std::int32_t merged_segments = 0;
  double widest_gap = 0.0;  // of those closed
  double deviation = 0.0;   // largest distance between the strokes and the chain of edges that stands for them
  double deviation_of_tolerance = 0.0;  // -; largest ratio of that distance to the tolerance at the place
};

// Lays strokes into the mesh: incremental constrained Delaunay on the mesh itself. Each point of a stroke is put on a
// point or a fixed edge closer than the snap distance, or becomes a point; each segment is recovered by flips, passing
// through points closer than the snap distance. A segment splits the fixed edges that it crosses (older lips, the
// border, its own earlier edges, region borders) at the rounded crossing. The edges it becomes are locked as cut; in
// the void nothing is inserted or locked. Segments longer than the spacing get points in between, except where the mesh
// has edges along them already: a long straight lip would drag needles as long as itself across the sheet. Of these
// points, those near lips of earlier cuts are left out, never two in a row.
class PathInsertion {
 public:
  // `spacing`: longest stretch of path without a point, as a fraction of the edge length there. `outline_edges`:
  // receives the edges that the strokes become; null if not needed.
  PathInsertion(mesh::MeshEditor& editor, const PathScale& scale, double spacing,
                OutlineEdges* outline_edges = nullptr);

  // Lays one stroke. Errors: those of cut::apply(); the editor must be rolled back then.
  Status insert(const Stroke& stroke);

  // Splits at its middle each new lip edge that meets no other lip and no border. Both its ends are tips, which stay
  // one vertex each, so it could not open otherwise. Call once, after the last stroke. Errors as of insert().
  Status split_lone_edges();

  [[nodiscard]] const InsertionCounts& counts() const { return counts_; }
  // Returns the mesh points on the path, sorted, unique.
  [[nodiscard]] std::vector<mesh::PointId> path_points() const;
  // Returns the tips, the path points where a cut ends inside the sheet. Exactly one lip edge, and no border edge,
  // meets a tip.
  [[nodiscard]] std::vector<mesh::PointId> tips() const;
  // Returns the end points of edges flipped away to make room for the path, sorted, unique.
  [[nodiscard]] std::vector<mesh::PointId> corridor_points() const;

 private:
  struct Snap {
    mesh::PointId point = mesh::kNone;        // nearest point within the snap distance, or
    mesh::TriangleId triangle = mesh::kNone;  // nearest fixed edge within it
    int corner = 0;
  };

  Status insert_segment(PathPosition& position);
  Status advance(PathPosition& position, const mesh::LatticePoint& at);
  bool retrace(PathPosition& position, const mesh::LatticePoint& at);
  bool follow_lips(PathPosition& from, std::vector<PathPosition>& targets);
  [[nodiscard]] LipTrace::Leg leg_to(const mesh::LatticePoint& from, const mesh::LatticePoint& to) const;
  void run_along_chain(mesh::PointId from);
  [[nodiscard]] bool is_near_older_lip(const mesh::LatticePoint& at) const;
  [[nodiscard]] bool runs_along_edge(const mesh::LatticePoint& at) const;
  Result<PathPosition> place(const mesh::LatticePoint& at);
  [[nodiscard]] Snap find_snap(const mesh::LatticePoint& at, mesh::TriangleId start) const;
  Result<mesh::PointId> insert_here(const mesh::LatticePoint& at, const mesh::Location& location);
  Result<mesh::PointId> split_near(mesh::TriangleId t, int corner, const mesh::LatticePoint& at);
  Status run_segment(PathPosition from, const PathPosition& to);
  [[nodiscard]] bool runs_through_sheet(const Encounter& arrival) const;
  Status recover_and_lock_edge(mesh::PointId p, mesh::PointId q);
  [[nodiscard]] bool is_on_lip(mesh::PointId point) const;
  void count_merged_segment();
  void record_gap(double width);
  [[nodiscard]] double distance_to_path(mesh::PointId point) const;
  void lock_as_cut(mesh::TriangleId t, int corner);
  void record_passed_point(mesh::PointId point);
  void record_point(mesh::PointId point);
  void record_deviation(mesh::PointId point, double distance);
  void use_scale_at(const mesh::LatticePoint& at);
  [[nodiscard]] bool is_tip(mesh::PointId point) const;

  mesh::MeshEditor& editor_;
  const mesh::TriangleMesh& mesh_;
  const PathScale& scale_;
  double spacing_;               // -
  OutlineEdges* outline_edges_;  // may be null
  double snap_ = 0.0;            // lattice units, where the path is
  PathWalk walk_;
  LipTrace trace_;
  InsertionCounts counts_;
  mesh::TriangleId hint_ = mesh::kNone;
  mesh::PointId last_point_ = mesh::kNone;          // where the stroke is
  mesh::LatticePoint segment_start_, segment_end_;  // of the stroke's segment being inserted
  std::vector<mesh::PointId> path_points_;
  std::vector<mesh::PointId> corridor_points_;
  std::vector<std::array<mesh::PointId, 2>> lip_edges_;  // new ones, by their ends; some have been split since
  std::int64_t legs_ = 0;
};

}  // namespace kerf::cut
