#include "server/fem/stiff_vertices.h"

#include <numeric>

#include "server/fem/stiff_parts.h"

namespace kerf::fem {

using mesh::VertexId;

void StiffVertices::rebuild(const Model& model, double limit) {
  limit_ = limit;
  is_stiff_.clear();
  count_ = 0;
  std::vector<VertexId> all(static_cast<std::size_t>(model.num_vertices()));
  std::iota(all.begin(), all.end(), 0);
  update(model, all);
}

void StiffVertices::follow(const Model& model, double limit) {
  if (limit != limit_) return rebuild(model, limit);
  for (std::size_t v = static_cast<std::size_t>(model.num_vertices()); v < is_stiff_.size(); ++v)
    count_ -= is_stiff_[v];
  update(model, model.changed_rows());
  update(model, model.changed_masses());
}

void StiffVertices::update(const Model& model, std::span<const VertexId> changed) {
  is_stiff_.resize(static_cast<std::size_t>(model.num_vertices()), 0);
  for (const VertexId v : changed) {
    const double row = membrane_row_sum(model, v) + bending_row_sum(model, v);
    std::uint8_t& is_stiff = is_stiff_[static_cast<std::size_t>(v)];
    count_ -= is_stiff;
    is_stiff = row > limit_ * model.mass()[static_cast<std::size_t>(v)] ? 1 : 0;
    count_ += is_stiff;
  }
}

}  // namespace kerf::fem
