#include "server/core/fem/model/tangent_matrix.h"

#include <algorithm>
#include <numeric>

#include "server/base/sort_unique.h"
#include "server/core/fem/element/angle_bending.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/majorized_membrane.h"
#include "server/core/fem/element/membrane_tangent.h"

namespace kerf::fem {
namespace {

constexpr std::size_t kRoom = 2;  // -, capacity over the number of blocks, so that cuts need not copy them

}  // namespace

void TangentMatrix::rebuild(const Model& model) {
  std::vector<mesh::VertexId> all(static_cast<std::size_t>(model.num_vertices()));
  std::iota(all.begin(), all.end(), 0);
  matrix_ = {};
  constexpr std::size_t kBlocksPerRow = 19;  // of an inner vertex of a grid with bending
  matrix_.reserve(kRoom * kBlocksPerRow * all.size());
  set_rows(model, all);
}

void TangentMatrix::follow(const Model& model) {
  set_rows(model, model.changed_rows());
}

// Sets columns_ to the columns of row v of the stiffness matrix.
void TangentMatrix::find_columns(const Model& model, mesh::VertexId v) {
  columns_.clear();
  // Patches reach beyond their triangles: rows of the bending matrix contain every column, in order.
  if (model.materials().has_bending()) {
    for (const BendingEntry& entry : model.bending().rows().row(v)) columns_.push_back(entry.column);
    if (!columns_.empty()) return;
  }
  columns_.push_back(v);
  for (const mesh::TriangleId slot : model.elements().incident_slots().row(v)) {
    const ElementBlock& block = model.element_blocks()[static_cast<std::size_t>(slot / kLanes)];
    for (std::size_t k = 0; k < 3; ++k) columns_.push_back(block.vertex[k][static_cast<std::size_t>(slot % kLanes)]);
  }
  sort_unique(columns_);
}

void TangentMatrix::set_rows(const Model& model, std::span<const mesh::VertexId> vertices) {
  const std::span<const ElementBlock> blocks = model.element_blocks();
  matrix_.resize(model.num_vertices());
  places_.resize(blocks.size() * kLanes);
  for (const mesh::VertexId v : vertices) {
    find_columns(model, v);
    matrix_.set_row(v, columns_);
    for (const mesh::TriangleId slot : model.elements().incident_slots().row(v)) {
      const auto lane = static_cast<std::size_t>(slot % kLanes);
      const ElementBlock& block = blocks[static_cast<std::size_t>(slot / kLanes)];
      const std::size_t i = (block.vertex[1][lane] == v ? 1U : 0U) + (block.vertex[2][lane] == v ? 2U : 0U);
      for (std::size_t j = 0; j < 3; ++j) {
        const auto at = std::lower_bound(columns_.begin(), columns_.end(), block.vertex[j][lane]);
        places_[static_cast<std::size_t>(slot)][3 * i + j] = static_cast<int>(at - columns_.begin());
      }
    }
  }
}

void TangentMatrix::set_mass(const Model& model, double inertia, double d) {
  matrix_.set_zero();
  for (int i = 0; i < matrix_.num_rows(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    matrix_.block(matrix_.diagonal(i))
        .diagonal()
        .setConstant(m > 0.0 ? (inertia + d * model.masses().damping(i)) * m : 1.0);
  }
}

void TangentMatrix::add_membrane(const Model& model, const linear::VertexField& x,
                                 std::span<const Eigen::Vector3d> stress, const MaterialScale& material_scale,
                                 double geometric_scale, bool project) {
  const std::span<const ElementBlock> blocks = model.element_blocks();
  LaneFrames frames;
  ElementMatrix K;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    frames_at(blocks[b], x, frames);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (blocks[b].area[l] == 0.0) continue;
      const MembraneTangent tangent(blocks[b], l, frames, model.materials());
      const Eigen::Vector3d sigma = stress.empty() ? tangent.stress() : stress[b * kLanes + l];
      tangent.stiffness(sigma, material_scale.of(blocks[b].material[l]), geometric_scale, project, K);
      const BlockPlaces& places = places_[b * kLanes + l];
      for (std::size_t i = 0; i < 3; ++i) {
        const int row = matrix_.row_begin(blocks[b].vertex[i][l]);
        for (std::size_t j = 0; j < 3; ++j) {
          matrix_.block(row + places[3 * i + j]) +=
              K.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j));
        }
      }
    }
  }
}

void TangentMatrix::add_majorized_membrane(const Model& model, const linear::VertexField& x, double scale) {
  const std::span<const ElementBlock> blocks = model.element_blocks();
  LaneFrames frames;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    frames_at(blocks[b], x, frames);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (blocks[b].area[l] == 0.0) continue;
      const MajorizedTriangle triangle(blocks[b], l, frames, model.materials());
      for (std::size_t i = 0; i < 3; ++i) {
        const int row = matrix_.row_begin(blocks[b].vertex[i][l]);
        for (std::size_t j = 0; j < 3; ++j) {
          matrix_.block(row + places_[b * kLanes + l][3 * i + j]).diagonal().array() +=
              scale * triangle.stiffness(static_cast<int>(i), static_cast<int>(j));
        }
      }
    }
  }
}

void TangentMatrix::add_bending(const Model& model, const MaterialScale& material_scale) {
  const linear::RowStore<BendingEntry>& rows = model.bending().rows();
  const bool is_same = is_uniform(material_scale.beta);
  const double scale = is_same ? material_scale.of(0) : material_scale.elastic;
  for (int i = 0; i < rows.num_rows(); ++i) {
    int at = matrix_.row_begin(i);
    for (const BendingEntry& entry : rows.row(i)) {
      while (matrix_.column(at) < entry.column) ++at;
      matrix_.block(at).diagonal().array() += scale * entry.value;
    }
  }
  if (!is_same) add_bending_damping(model, material_scale);
}

void TangentMatrix::add_bending_at(const Model& model, const linear::VertexField& x, std::span<const double> moments,
                                   bool project) {
  if (model.bending().angles() == nullptr) return add_bending(model, {});
  model.bending().angles()->add_stiffness(x, moments, project, matrix_);
}

void TangentMatrix::add_bending_damping(const Model& model, const MaterialScale& scale) {
  const BendingTerms terms = model.bending().terms(model.element_blocks());
  const auto add = [&](std::span<const mesh::VertexId> vertex, double factor, const auto& entry) {
    for (std::size_t a = 0; factor > 0.0 && a < vertex.size(); ++a) {
      for (std::size_t b = 0; b < vertex.size(); ++b) {
        if (vertex[a] == mesh::kNone || vertex[b] == mesh::kNone) continue;
        matrix_.block(matrix_.find(vertex[a], vertex[b])).diagonal().array() += factor * entry(a, b);
      }
    }
  };
  for (std::size_t slot = 0; slot < terms.patches.size(); ++slot) {
    const BendingPatch& patch = terms.patches[slot];
    const double beta = damping_of(scale.beta, terms.blocks[slot / kLanes].material[slot % kLanes]);
    add(patch.vertex, scale.d * beta,
        [&](std::size_t a, std::size_t b) { return patch.at(static_cast<int>(a), static_cast<int>(b)); });
    for (const BendingEdge& edge : terms.edges.row(static_cast<int>(slot))) {
      add(edge.vertex, scale.d * edge_damping(scale.beta, edge),
          [&](std::size_t a, std::size_t b) { return edge.at(a, b); });
    }
  }
}

void TangentMatrix::add_grabs(std::span<const Grab> grabs, double d) {
  for (const Grab& grab : grabs) {
    const double stiffness = d * d * grab.stiffness + d * grab.damping;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        if (grab.vertices[i] == mesh::kNone || grab.vertices[j] == mesh::kNone) continue;
        const double weight = grab.weights[static_cast<Eigen::Index>(i)] * grab.weights[static_cast<Eigen::Index>(j)];
        const int at = matrix_.find(grab.vertices[i], grab.vertices[j]);
        if (at >= 0) matrix_.block(at).diagonal().array() += stiffness * weight;
      }
    }
  }
}

void TangentMatrix::add_follower_loads(const Model& model, const Loads& loads, const linear::VertexField& x,
                                       double scale, MatrixPart part) {
  add_pressure(model, loads, x, scale, part);
  for (const EdgeMoment& moment : loads.edge_moments) {
    const EdgeMomentTangent tangent(moment, x);
    for (std::size_t a = 0; a < moment.vertex.size(); ++a) {
      for (std::size_t b = 0; b < moment.vertex.size(); ++b) {
        if (moment.vertex[a] == mesh::kNone || moment.vertex[b] == mesh::kNone) continue;
        const int at = matrix_.find(moment.vertex[a], moment.vertex[b]);
        if (at >= 0) matrix_.block(at) += scale * tangent.stiffness(a, b, part);
      }
    }
  }
}

void TangentMatrix::add_pressure(const Model& model, const Loads& loads, const linear::VertexField& x, double scale,
                                 MatrixPart part) {
  const std::span<const ElementBlock> blocks = model.element_blocks();
  const std::size_t num_pressed = std::min(loads.pressure.size(), blocks.size() * kLanes);
  for (std::size_t slot = 0; slot < num_pressed; ++slot) {
    const ElementBlock& block = blocks[slot / kLanes];
    const std::size_t lane = slot % kLanes;
    if (loads.pressure[slot] == 0.0 || block.area[lane] == 0.0) continue;
    std::array<Eigen::Vector3d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = x.col(block.vertex[k][lane]);
    for (std::size_t i = 0; i < 3; ++i) {
      const int row = matrix_.row_begin(block.vertex[i][lane]);
      for (std::size_t j = 0; j < 3; ++j) {
        matrix_.block(row + places_[slot][3 * i + j]) +=
            pressure_stiffness(scale * loads.pressure[slot], corner, i, j, part);
      }
    }
  }
}

void TangentMatrix::clear_pinned(std::span<const Pin> pins) {
  for (const Pin& pin : pins) {
    const Eigen::Vector3d free = pin.held(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
    for (int at = matrix_.row_begin(pin.vertex); at < matrix_.row_end(pin.vertex); ++at) {
      matrix_.block(at) = free.asDiagonal() * matrix_.block(at);
      const int mirrored = matrix_.find(matrix_.column(at), pin.vertex);
      matrix_.block(mirrored) = matrix_.block(mirrored) * free.asDiagonal();
    }
  }
}

void TangentMatrix::constrain(const Model& model, std::span<const Pin> pins, double time_left,
                              const linear::VertexField& x, linear::VertexField& rhs, linear::VertexField& step) {
  for (const Pin& pin : pins) {
    const Eigen::Vector3d displacement =
        pin.held(pin.target - time_left * pin.velocity - x.col(pin.vertex), Eigen::Vector3d::Zero());
    const Eigen::Vector3d free = pin.held(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
    for (int at = matrix_.row_begin(pin.vertex); at < matrix_.row_end(pin.vertex); ++at) {
      const int j = matrix_.column(at);
      if (j == pin.vertex) continue;
      rhs.col(j) -= matrix_.block(at).transpose() * displacement;
      matrix_.block(at) = free.asDiagonal() * matrix_.block(at);
      matrix_.block(matrix_.find(j, pin.vertex)) = matrix_.block(at).transpose();
    }
    Eigen::Matrix3d& diagonal = matrix_.block(matrix_.diagonal(pin.vertex));
    rhs.col(pin.vertex) -= diagonal * displacement;
    // Any positive diagonal entry decouples a held component. With the mass, it has about the size of the other
    // entries.
    const double m = model.mass()[static_cast<std::size_t>(pin.vertex)];
    const double scale = m > 0.0 ? m : 1.0;
    diagonal = free.asDiagonal() * diagonal * free.asDiagonal();
    diagonal.diagonal() += scale * (Eigen::Vector3d::Ones() - free);
    step.col(pin.vertex) = pin.held(displacement, step.col(pin.vertex));
  }
  for (const Pin& pin : pins) {
    const Eigen::Matrix3d& diagonal = matrix_.block(matrix_.diagonal(pin.vertex));
    rhs.col(pin.vertex) = pin.held(diagonal.diagonal().cwiseProduct(step.col(pin.vertex)), rhs.col(pin.vertex));
  }
}

}  // namespace kerf::fem
