#include "server/core/fem/model/transfer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "server/base/check.h"
#include "server/base/sort_unique.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

constexpr double kSameMass = 1e-9;  // -, largest change of the mass of the touched vertices that still counts as none

Eigen::Vector3d interpolate(const mesh::VertexSource& source, const linear::VertexField& field) {
  if (source.weights[0] == 1.0 && source.weights[1] == 0.0) return field.col(source.sources[0]);
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const double weight = source.weights[static_cast<Eigen::Index>(k)];
    if (weight != 0.0) value += weight * field.col(source.sources[k]);
  }
  return value;
}

// Returns the interpolated values without writing them, because moved vertices may be sources of others.
std::vector<Eigen::Vector3d> interpolate(const std::vector<mesh::VertexSource>& sources,
                                         const linear::VertexField& field) {
  std::vector<Eigen::Vector3d> values;
  values.reserve(sources.size());
  for (const mesh::VertexSource& source : sources) values.push_back(interpolate(source, field));
  return values;
}

void write(const std::vector<mesh::VertexSource>& sources, const std::vector<Eigen::Vector3d>& values,
           linear::VertexField& field) {
  for (std::size_t i = 0; i < values.size(); ++i) field.col(sources[i].vertex) = values[i];
}

// Interpolates the columns of `field` for all added and moved vertices from its values before the edit.
void transfer_field(const mesh::MeshEdit& edit, linear::VertexField& field) {
  const std::vector<Eigen::Vector3d> moved = interpolate(edit.moved_vertices, field);
  const std::vector<Eigen::Vector3d> added = interpolate(edit.added_vertices, field);
  write(edit.moved_vertices, moved, field);
  write(edit.added_vertices, added, field);
}

// Adds one velocity to all `vertices`, so that they gain the momentum `missing` (kg m/s). Masses are in kg, of all of
// them together.
void shift(const std::vector<mesh::VertexId>& vertices, const Eigen::Vector3d& missing, double mass_before,
           double mass_after, State& state) {
  if (mass_after <= 0.0 || std::abs(mass_after - mass_before) > kSameMass * mass_before) return;
  const Eigen::Vector3d step = missing / mass_after;
  for (const mesh::VertexId v : vertices) state.v.col(v) += step;
}

// Masses of all vertices before a change.
class MassesBefore {
 public:
  MassesBefore(const Model& model, const MassChange& change) : model_(model), dropped_(change.dropped) {
    for (std::size_t i = 0; i < change.vertices.size(); ++i)
      changed_.emplace(change.vertices[i], change.mass_before[i]);
  }
  [[nodiscard]] mesh::VertexId num_vertices() const {
    return model_.num_vertices() + static_cast<mesh::VertexId>(dropped_.size());
  }
  [[nodiscard]] double of(mesh::VertexId v) const {  // kg
    if (v >= model_.num_vertices()) return dropped_[static_cast<std::size_t>(v - model_.num_vertices())];
    const auto changed = changed_.find(v);
    return changed != changed_.end() ? changed->second : model_.mass()[static_cast<std::size_t>(v)];
  }

 private:
  const Model& model_;
  std::span<const double> dropped_;
  std::unordered_map<mesh::VertexId, double> changed_;  // looked up, never iterated
};

// Merges removed vertices into those that they came from.
class Fold {
 public:
  Fold(const MassesBefore& mass_before, State& state) : mass_before_(mass_before), state_(state) {}

  void revert(const mesh::RevertedEdit& reverted) {
    revive(reverted.restored_vertices);
    const std::vector<Eigen::Vector3d> x = interpolate(reverted.moved_vertices, state_.x);
    const std::vector<Eigen::Vector3d> v = interpolate(reverted.moved_vertices, state_.v);
    write(reverted.moved_vertices, x, state_.x);
    write(reverted.moved_vertices, v, state_.v);
    for (const mesh::VertexSource& gone : reverted.removed_vertices) {
      if (mesh::is_copy(gone)) join(gone);
    }
    for (const mesh::VertexSource& gone : reverted.removed_vertices) {
      if (!mesh::is_copy(gone)) share_out(gone);
    }
  }

 private:
  // Sets position and velocity of vertices whose removed material is back, each from a triangle near it. Positions
  // extrapolate the triangle. Velocities are a mean of its corners, because extrapolated ones would grow.
  void revive(std::vector<mesh::VertexSource> sources) {
    write(sources, interpolate(sources, state_.x), state_.x);
    for (mesh::VertexSource& source : sources) {
      source.weights = source.weights.cwiseMax(0.0);
      source.weights /= source.weights.sum();
    }
    write(sources, interpolate(sources, state_.v), state_.v);
  }

  double& mass(mesh::VertexId v) { return mass_.try_emplace(v, mass_before_.of(v)).first->second; }

  // Adds mass to a vertex and returns the share of `added` in its total mass.
  double grow(mesh::VertexId vertex, double added) {
    double& total = mass(vertex);
    total += added;
    return total > 0.0 ? added / total : 0.0;
  }

  // Lips that lie together and move together still do so afterwards, bit for bit: the difference is then zero.
  void join(const mesh::VertexSource& gone) {
    const mesh::VertexId kept = gone.sources[0];
    const double part = grow(kept, mass(gone.vertex));
    state_.x.col(kept) += part * (state_.x.col(gone.vertex) - state_.x.col(kept));
    state_.v.col(kept) += part * (state_.v.col(gone.vertex) - state_.v.col(kept));
  }

  void share_out(const mesh::VertexSource& gone) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double weight = gone.weights[static_cast<Eigen::Index>(k)];
      if (weight == 0.0) continue;
      const double part = grow(gone.sources[k], weight * mass(gone.vertex));
      state_.v.col(gone.sources[k]) += part * (state_.v.col(gone.vertex) - state_.v.col(gone.sources[k]));
    }
  }

  const MassesBefore& mass_before_;
  // kg, including merged vertices; looked up, never iterated.
  std::unordered_map<mesh::VertexId, double> mass_;
  State& state_;
};

// Returns the remaining vertices whose mass or velocity the reverts change; sorted, unique.
std::vector<mesh::VertexId> touched_vertices(std::span<const mesh::RevertedEdit> reverted, const MassChange& change,
                                             std::int32_t num_vertices) {
  std::vector<mesh::VertexId> touched = change.vertices;
  for (const mesh::RevertedEdit& edit : reverted) {
    for (const mesh::VertexSource& moved : edit.moved_vertices) touched.push_back(moved.vertex);
    for (const mesh::VertexSource& gone : edit.removed_vertices) {
      touched.insert(touched.end(), gone.sources.begin(), gone.sources.end());
    }
  }
  sort_unique(touched);
  touched.erase(std::lower_bound(touched.begin(), touched.end(), num_vertices), touched.end());
  return touched;
}

}  // namespace

void transfer_state(std::span<const mesh::MeshEdit* const> edits, const Model& model, const MassChange& change,
                    State& state) {
  const auto num_before = state.x.cols();
  auto num_after = num_before;
  for (const mesh::MeshEdit* edit : edits) num_after += static_cast<Eigen::Index>(edit->added_vertices.size());
  KERF_CHECK(num_after == model.num_vertices(), "state, edits and model are of one mesh");
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  // of the touched vertices, before minus after
  double mass_before = 0.0;
  for (std::size_t i = 0; i < change.vertices.size(); ++i) {
    mass_before += change.mass_before[i];
    if (change.vertices[i] < num_before) momentum += change.mass_before[i] * state.v.col(change.vertices[i]);
  }
  state.x.resize(num_after);
  state.v.resize(num_after);
  for (const mesh::MeshEdit* edit : edits) {
    transfer_field(*edit, state.x);
    transfer_field(*edit, state.v);
    for (const mesh::VertexId v : edit->removed_vertices) state.v.col(v).setZero();
  }
  double mass_after = 0.0;
  for (const mesh::VertexId v : change.vertices) {
    const double m = model.mass()[static_cast<std::size_t>(v)];
    mass_after += m;
    momentum -= m * state.v.col(v);
  }
  shift(change.vertices, momentum, mass_before, mass_after, state);
}

void transfer_state(const mesh::MeshEdit& edit, const Model& model, const MassChange& change, State& state) {
  const std::array<const mesh::MeshEdit*, 1> edits{&edit};
  transfer_state(edits, model, change, state);
}

void carry_over(const mesh::MeshEdit& edit, linear::VertexField& field) {
  field.resize(field.cols() + static_cast<Eigen::Index>(edit.added_vertices.size()));
  transfer_field(edit, field);
}

void revert_state(std::span<const mesh::RevertedEdit> reverted, const Model& model, const MassChange& change,
                  State& state) {
  if (reverted.empty()) return;
  const std::int32_t num_after = reverted.back().num_vertices;
  const MassesBefore mass_before(model, change);
  KERF_CHECK(num_after == model.num_vertices() && mass_before.num_vertices() == state.x.cols(),
             "state, reverted edits and model are of one mesh");
  const std::vector<mesh::VertexId> touched = touched_vertices(reverted, change, num_after);
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  // of touched and removed vertices, before minus after
  double total_before = 0.0;
  const auto add = [&](mesh::VertexId v) {
    const double m = mass_before.of(v);
    total_before += m;
    momentum += m * state.v.col(v);
  };
  for (const mesh::VertexId v : touched) add(v);
  for (auto v = num_after; v < mass_before.num_vertices(); ++v) add(v);

  Fold fold(mass_before, state);
  for (const mesh::RevertedEdit& edit : reverted) fold.revert(edit);
  state.x.resize(num_after);
  state.v.resize(num_after);

  double total_after = 0.0;
  for (const mesh::VertexId v : touched) {
    const double m = model.mass()[static_cast<std::size_t>(v)];
    total_after += m;
    momentum -= m * state.v.col(v);
  }
  shift(touched, momentum, total_before, total_after, state);
}

}  // namespace kerf::fem
