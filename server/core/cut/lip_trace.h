#pragma once

#include <vector>

#include "server/core/cut/path_scale.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// Finds chains of existing lips or border edges along which the path runs. A line that was cut once must be found
// again, however many other lips are near. All points of a chain are closer to the path than the snap distance.
class LipTrace {
 public:
  LipTrace(const mesh::TriangleMesh& mesh, const PathScale& scale) : mesh_(mesh), scale_(scale) {}

  // A straight stretch of the path.
  struct Leg {
    mesh::LatticePoint start, end;
  };

  // The three functions below look for a chain of lips and border edges from `from` along the leg. They return true if
  // there is one; chain() then has it.

  // Looks for a chain to the point nearest to the end of the leg, which must be closer to it than the snap distance.
  bool find(mesh::PointId from, const Leg& leg);
  // Looks for a chain to the point `to`.
  bool find(mesh::PointId from, mesh::PointId to, const Leg& leg);
  // Looks for a chain to the border point nearest to the end of the leg, which must be nearer to it than `from` is.
  bool find_border(mesh::PointId from, const Leg& leg);

  // Points of the chain found last, in order, without `from`. Empty if the chain ends at `from` itself.
  [[nodiscard]] const std::vector<mesh::PointId>& chain() const { return chain_; }

 private:
  struct Visit {
    mesh::PointId point = mesh::kNone;
    std::size_t came_from = 0;  // index into visits_ of the point before it
    bool on_border = false;
  };

  void visit_all(mesh::PointId from, const Leg& leg);
  void visit_neighbours(std::size_t of, const Leg& leg);
  [[nodiscard]] bool is_along(mesh::PointId point, const Leg& leg) const;
  [[nodiscard]] bool was_visited(mesh::PointId point) const;
  [[nodiscard]] double distance_to_end(const Visit& visit, const Leg& leg) const;
  void take_chain(std::size_t last);

  const mesh::TriangleMesh& mesh_;
  const PathScale& scale_;
  std::vector<Visit> visits_;
  std::vector<mesh::PointId> chain_;
  std::vector<mesh::TriangleId> fan_;
};

}  // namespace kerf::cut
