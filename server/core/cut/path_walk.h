#pragma once

#include <array>
#include <vector>

#include "server/core/cut/path_scale.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// Position of the path: at a point of the mesh, or somewhere in a void triangle (the path leaves no points in the
// void).
struct PathPosition {
  mesh::LatticePoint at;
  mesh::PointId point = mesh::kNone;        // kNone in the void
  mesh::TriangleId triangle = mesh::kNone;  // in the void: a slot that holds `at`, or held it a few edits ago
};

// First encounter of a straight leg of the path.
struct Encounter {
  enum class Kind {
    kArrived,    // reaches its end across flippable edges only
    kPoint,      // `point` lies on the leg, or closer to it than the clearance, between its ends
    kFixedEdge,  // crosses edge `corner` of `triangle`, which must be split
    kLost,       // the step counter ran out
  };
  Kind kind = Kind::kLost;
  mesh::TriangleId triangle = mesh::kNone;  // kArrived in the void: the slot that holds the end
  int corner = 0;
  mesh::PointId point = mesh::kNone;
  bool edge_exists = false;  // kArrived: the leg is an edge already
  bool solid = false;        // the leg ran through solid triangles up to here, else through void ones
};

// Follows legs of the path through the welded mesh by exact predicates. Keeps scratch between legs.
class PathWalk {
 public:
  PathWalk(const mesh::TriangleMesh& mesh, const PathScale& scale) : mesh_(mesh), scale_(scale) {}

  // Sets the straight line that the following legs stand for. A leg meets points closer than the snap distance to both.
  void set_line(const mesh::LatticePoint& from, const mesh::LatticePoint& to) { line_ = {from, to}; }

  // Follows the leg from `from` to `to`, at different places, up to its first encounter. A position without a point
  // must lie in the void and from.triangle must hold it now.
  Encounter follow(const PathPosition& from, const PathPosition& to);

  // Returns the end points of the flippable edges that the last leg crossed, in order, with repeats.
  [[nodiscard]] const std::vector<mesh::PointId>& corridor() const { return corridor_; }

 private:
  // Edge `corner` of `triangle`, about to be crossed.
  struct Exit {
    mesh::TriangleId triangle = mesh::kNone;
    int corner = 0;
  };

  // Find the edge by which the leg leaves its first triangle; where it meets something before, fill `met` and return
  // false.
  bool leave_point(Exit& exit, Encounter& met);
  bool leave_void_triangle(Exit& exit, Encounter& met) const;
  [[nodiscard]] bool holds_end(mesh::TriangleId t) const;
  // Returns true if the leg should pass through v. It must be closer than the snap distance. It must also be nearer to
  // either end than the ends are to each other, so that legs only get shorter. If it is farther from the leg than
  // rounding explains, it must be within the snap distance of the whole line too. Else a leg led to one lip would be
  // led to the next, ever farther from the path.
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
