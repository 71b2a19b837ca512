// The matrix of StageSolver.
#include "server/fem/stage_solver.h"

namespace kerf::fem {

void StageSolver::assemble(const Problem& problem, const mesh::VertexField& x, bool predicted) {
  matrix_.set_zero();
  const double inertia = 1.0 + problem.stage.d * problem.model.material().mass_damping;
  for (int i = 0; i < matrix_.num_rows(); ++i) {
    const double m = problem.model.mass()[static_cast<std::size_t>(i)];
    matrix_.block(matrix_.diagonal(i)).diagonal().setConstant(m > 0.0 ? inertia * m : 1.0);
  }
  add_membrane(problem, x, predicted);
  add_bending_and_grabs(problem);
}

void StageSolver::add_membrane(const Problem& problem, const mesh::VertexField& x, bool predicted) {
  const double geometric_scale = problem.stage.d * problem.stage.d;
  const double material_scale = geometric_scale + problem.stage.d * problem.beta;
  const std::span<const ElementBlock> blocks = problem.model.element_blocks();
  LaneFrames frames;
  ElementMatrix K;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    frames_at(blocks[b], x, frames);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (blocks[b].area[l] == 0.0) continue;
      const MembraneTangent tangent(blocks[b], l, frames, problem.model.membrane_law());
      const Eigen::Vector3d sigma = predicted ? stress_[b * kLanes + l] : tangent.stress();
      tangent.stiffness(sigma, material_scale, geometric_scale, true, K);
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

void StageSolver::add_bending_and_grabs(const Problem& problem) {
  const double d = problem.stage.d;
  const double scale = d * d + d * problem.beta;
  const RowStore<BendingEntry>& rows = problem.model.bending_rows();
  for (int i = 0; i < rows.num_rows(); ++i) {
    int at = matrix_.row_begin(i);
    for (const BendingEntry& entry : rows.row(i)) {
      while (matrix_.column(at) < entry.column) ++at;
      matrix_.block(at).diagonal().array() += scale * entry.value;
    }
  }
  for (const Grab& grab : problem.loads.grabs) {
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

void StageSolver::predict_stress(const Problem& problem, const mesh::VertexField& x) {
  const std::span<const ElementBlock> blocks = problem.model.element_blocks();
  LaneFrames frames;
  ElementVector dx;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    frames_at(blocks[b], x, frames);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (blocks[b].area[l] == 0.0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        dx.segment<3>(static_cast<Eigen::Index>(3 * k)) = step_.col(blocks[b].vertex[k][l]);
      }
      const MembraneTangent tangent(blocks[b], l, frames, problem.model.membrane_law());
      stress_[b * kLanes + l] = tangent.predicted_stress(dx);
    }
  }
}

void StageSolver::constrain(const Problem& problem, const mesh::VertexField& x) {
  for (const Pin& pin : problem.loads.pins) {
    const Eigen::Vector3d displacement =
        pin.held(pin.target - problem.stage.time_left * pin.velocity - x.col(pin.vertex), Eigen::Vector3d::Zero());
    const Eigen::Vector3d free = pin.held(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
    for (int at = matrix_.row_begin(pin.vertex); at < matrix_.row_end(pin.vertex); ++at) {
      const int j = matrix_.column(at);
      if (j == pin.vertex) continue;
      rhs_.col(j) -= matrix_.block(at).transpose() * displacement;
      matrix_.block(at) = free.asDiagonal() * matrix_.block(at);
      matrix_.block(matrix_.find(j, pin.vertex)) = matrix_.block(at).transpose();
    }
    Eigen::Matrix3d& diagonal = matrix_.block(matrix_.diagonal(pin.vertex));
    rhs_.col(pin.vertex) -= diagonal * displacement;
    // Any positive multiple of the identity decouples components; the mass keeps it of the size of the others.
    const double m = problem.model.mass()[static_cast<std::size_t>(pin.vertex)];
    const double scale = m > 0.0 ? m : 1.0;
    diagonal = free.asDiagonal() * diagonal * free.asDiagonal();
    diagonal.diagonal() += scale * (Eigen::Vector3d::Ones() - free);
    step_.col(pin.vertex) = pin.held(displacement, step_.col(pin.vertex));
  }
  for (const Pin& pin : problem.loads.pins) {
    const Eigen::Matrix3d& diagonal = matrix_.block(matrix_.diagonal(pin.vertex));
    rhs_.col(pin.vertex) = pin.held(diagonal.diagonal().cwiseProduct(step_.col(pin.vertex)), rhs_.col(pin.vertex));
  }
}

}  // namespace kerf::fem
