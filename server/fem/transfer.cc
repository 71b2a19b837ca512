#include "server/fem/transfer.h"

#include <cmath>

#include "server/base/check.h"

namespace kerf::fem {
namespace {

// Columns of `field` (3 x V before the edit) for every added and moved vertex.
void transfer_field(const mesh::MeshEdit& edit, int num_vertices, Eigen::Matrix3Xd& field) {
  const auto interpolate = [&field](const mesh::VertexSource& source) {
    if (source.weights[0] == 1.0) return Eigen::Vector3d(field.col(source.sources[0]));
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double weight = source.weights[static_cast<Eigen::Index>(k)];
      if (weight != 0.0) value += weight * field.col(source.sources[k]);
    }
    return value;
  };
  // Moved vertices may be sources of others: all values are taken before any is written.
  std::vector<Eigen::Vector3d> moved;
  moved.reserve(edit.moved_vertices.size());
  for (const mesh::VertexSource& source : edit.moved_vertices) moved.push_back(interpolate(source));
  std::vector<Eigen::Vector3d> added;
  added.reserve(edit.added_vertices.size());
  for (const mesh::VertexSource& source : edit.added_vertices) added.push_back(interpolate(source));

  field.conservativeResize(Eigen::NoChange, num_vertices);
  for (std::size_t i = 0; i < moved.size(); ++i) field.col(edit.moved_vertices[i].vertex) = moved[i];
  for (std::size_t i = 0; i < added.size(); ++i) field.col(edit.added_vertices[i].vertex) = added[i];
}

}  // namespace

void transfer_state(const mesh::MeshEdit& edit, const Model& model, const MassChange& change, State& state) {
  constexpr double kSameMass = 1e-9;  // -, of the touched mass
  const auto num_before = state.x.cols();
  KERF_CHECK(num_before + static_cast<Eigen::Index>(edit.added_vertices.size()) == model.num_vertices(),
             "state, edit and model are of one mesh");
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  // of the touched vertices, before minus after
  double mass_before = 0.0;
  for (std::size_t i = 0; i < change.vertices.size(); ++i) {
    mass_before += change.mass_before[i];
    if (change.vertices[i] < num_before) momentum += change.mass_before[i] * state.v.col(change.vertices[i]);
  }
  transfer_field(edit, model.num_vertices(), state.x);
  transfer_field(edit, model.num_vertices(), state.v);
  double mass_after = 0.0;
  for (const mesh::VertexId v : change.vertices) {
    const double m = model.mass()[static_cast<std::size_t>(v)];
    mass_after += m;
    momentum -= m * state.v.col(v);
  }
  if (mass_after <= 0.0 || std::abs(mass_after - mass_before) > kSameMass * mass_before) return;
  const Eigen::Vector3d shift = momentum / mass_after;
  for (const mesh::VertexId v : change.vertices) state.v.col(v) += shift;
}

}  // namespace kerf::fem
