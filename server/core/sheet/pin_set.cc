#include "server/core/sheet/pin_set.h"

#include <algorithm>
#include <utility>

namespace kerf::sheet {

void PinSet::hold(std::vector<mesh::VertexId> vertices, fem::State& state) {
  vertices_ = std::move(vertices);
  holds_.clear();
  holds_.reserve(vertices_.size());
  for (const mesh::VertexId v : vertices_) {
    state.v.col(v).setZero();
    holds_.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
}

std::vector<fem::Pin> PinSet::lost_by(const mesh::MeshEdit& edit) const {
  std::vector<fem::Pin> lost;
  for (const fem::Pin& p : holds_) {
    if (std::binary_search(edit.removed_vertices.begin(), edit.removed_vertices.end(), p.vertex)) lost.push_back(p);
  }
  return lost;
}

}  // namespace kerf::sheet
