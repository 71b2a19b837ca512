#pragma once

#include <vector>

#include "server/core/cut/path_scale.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// Finds where the path runs along existing lips, or the border. A line that was cut once must be found again, however
// many other lips are near. Chains that it follows lie closer to the path than the snap distance. Keeps scratch between
// legs.
class LipTrace {
 public:
  LipTrace(const mesh::TriangleMesh& mesh, const PathScale& scale) : mesh_(mesh), scale_(scale) {}

  // A straight stretch of the path.
  struct Leg {
    mesh::LatticePoint start, end;
  };

  // Each of these looks for a chain of lips and border edges from `from` along the leg; returns true if there is one,
  // see chain(). This one leads to the nearest point closer to the end of the leg than the snap distance.
  bool find(mesh::PointId from, const Leg& leg);
  // Leads to `to`.
  bool find(mesh::PointId from, mesh::PointId to, const Leg& leg);
  // Leads to the point of the border that is nearest to the end of the leg, and nearer than `from`.
  bool find_border(mesh::PointId from, const Leg& leg);

  // Points of the chain found last, `from` not among them, its end the last; empty where that is `from`.
  [[nodiscard]] const std::vector<mesh::PointId>& chain() const { return chain_; }

 private:
  struct Visit {
    mesh::PointId point = mesh::kNone;
    std::size_t came_from = 0;  // into visits_
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
