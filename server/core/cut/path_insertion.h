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
  double widest_gap = 0.0;              // largest distance of a closed gap
  double deviation = 0.0;               // largest distance between the strokes and the edges that they became
  double deviation_of_tolerance = 0.0;  // -; largest ratio of that distance to the local tolerance
};

// Puts strokes into the mesh: incremental constrained Delaunay triangulation on the mesh itself. Each point of a stroke
// is moved to a point or fixed edge within the snap distance, or becomes a new point. Each segment is made a chain of
// edges by flips, which passes through points within the snap distance. A segment splits the fixed edges that it
// crosses at the rounded crossing. These are older lips, the border, region borders, and its own earlier edges. The
// edges that it becomes are locked as cut. In the void nothing is inserted or locked.
//
// Segments longer than the spacing get points in between, since a long straight lip would force needles as long as
// itself. Stretches that have edges along them already get none. Points near lips of earlier cuts are left out too, but
// never two in a row.
class PathInsertion {
 public:
  // `spacing`: longest stretch of path without a point, over the local edge length. `outline_edges`: receives the edges
  // that the strokes become; null if not needed.
  PathInsertion(mesh::MeshEditor& editor, const PathScale& scale, double spacing,
                OutlineEdges* outline_edges = nullptr);

  // Puts one stroke into the mesh. Errors: those of cut::apply(). After an error the editor must be rolled back.
  Status insert(const Stroke& stroke);

  // Splits each new lip edge that meets no other lip and no border at its middle. Both its ends are tips, which stay
  // one vertex each, so the unsplit edge could not open. Call once, after the last stroke. Errors as of insert().
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
    mesh::TriangleId triangle = mesh::kNone;  // nearest fixed edge within the snap distance
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
  double snap_ = 0.0;            // snap distance where the path is now, lattice units
  PathWalk walk_;
  LipTrace trace_;
  InsertionCounts counts_;
  mesh::TriangleId hint_ = mesh::kNone;
  mesh::PointId last_point_ = mesh::kNone;          // point at which the stroke has arrived
  mesh::LatticePoint segment_start_, segment_end_;  // ends of the segment of the stroke that is being inserted
  std::vector<mesh::PointId> path_points_;
  std::vector<mesh::PointId> corridor_points_;
  std::vector<std::array<mesh::PointId, 2>> lip_edges_;  // edges locked as cut, by their ends; some have been split
                                                         // since
  std::int64_t legs_ = 0;
};

}  // namespace kerf::cut
