#pragma once

#include <array>
#include <vector>

#include "server/core/cut/path_scale.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// The place that the path has reached: a mesh point, or a place in a void triangle, where the path makes no points.
struct PathPosition {
  mesh::LatticePoint at;
  mesh::PointId point = mesh::kNone;        // kNone in the void
  mesh::TriangleId triangle = mesh::kNone;  // in the void: a slot that holds `at`, or held it before the last few
                                            // operations
};

// The first thing that a straight leg of the path meets.
struct Encounter {
  enum class Kind {
    kArrived,    // the leg reaches its end across flippable edges only
    kPoint,      // `point` lies on the leg or within the snap distance of it, between its ends
    kFixedEdge,  // the leg crosses edge `corner` of `triangle`, which must be split
    kLost,       // too many steps
  };
  Kind kind = Kind::kLost;
  mesh::TriangleId triangle = mesh::kNone;  // kArrived in the void: the slot that holds the end
  int corner = 0;
  mesh::PointId point = mesh::kNone;
  bool edge_exists = false;  // kArrived: the leg is an edge already
  bool solid = false;        // true if the leg ran through solid triangles up to here, false if through void ones
};

// Follows legs, straight stretches of the path, through the welded mesh with exact predicates.
class PathWalk {
 public:
  PathWalk(const mesh::TriangleMesh& mesh, const PathScale& scale) : mesh_(mesh), scale_(scale) {}

  // Sets the segment of the path that the following legs are parts of. A leg passes through points that are within the
  // snap distance of both leg and segment.
  void set_line(const mesh::LatticePoint& from, const mesh::LatticePoint& to) { line_ = {from, to}; }

  // Follows the leg from `from` to `to`, which are different places, up to its first encounter. A position without a
  // point must lie in the void; from.triangle must then hold it at present.
  Encounter follow(const PathPosition& from, const PathPosition& to);

  // Returns the end points of the flippable edges that the last leg crossed, in order, with repeats.
  [[nodiscard]] const std::vector<mesh::PointId>& corridor() const { return corridor_; }

 private:
  // Edge `corner` of `triangle`, about to be crossed.
  struct Exit {
    mesh::TriangleId triangle = mesh::kNone;
    int corner = 0;
  };

  // Find the edge by which the leg leaves its first triangle. If the leg meets something before, they set `met` and
  // return false.
  bool leave_point(Exit& exit, Encounter& met);
  bool leave_void_triangle(Exit& exit, Encounter& met) const;
  [[nodiscard]] bool holds_end(mesh::TriangleId t) const;
  // Returns true if the leg should pass through point v. Then v is within the snap distance of the leg. It is nearer to
  // both ends than these are to each other, so that legs only get shorter. If it is farther from the leg than rounding
  // explains, it must also be within the snap distance of the segment. Otherwise a leg that was moved to one lip would
  // be moved on to the next, farther and farther from the path.
  [[nodiscard]] bool is_met(mesh::PointId v) const;

  const mesh::TriangleMesh& mesh_;
  const PathScale& scale_;
  std::array<mesh::LatticePoint, 2> line_;
  PathPosition from_;
  PathPosition to_;
  std::vector<mesh::TriangleId> fan_;
  std::vector<mesh::PointId> corridor_;
};

}  // namespace kerf::cut
