#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "server/core/fem/element/angle_bending.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/membrane_tangent.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tangent_matrix.h"

// The parts of a sheet's energy behind one face, as the contract of elements asks for them.
namespace kerf::fem {

class Element {
 public:
  Element(const mesh::TriangleMesh& mesh, const Material& material, MembraneLaw law) : model(mesh, material, law) {}
  virtual ~Element() = default;
  Element(const Element&) = delete;
  Element& operator=(const Element&) = delete;
  Element(Element&&) = delete;
  Element& operator=(Element&&) = delete;

  [[nodiscard]] virtual double energy(const linear::VertexField& x) const = 0;               // J
  [[nodiscard]] virtual linear::VertexField forces(const linear::VertexField& x) const = 0;  // 3 x V, N
  // 3V x 3V, N/m; where `project`, changed to be positive semidefinite.
  [[nodiscard]] virtual Eigen::MatrixXd stiffness(const linear::VertexField& x, bool project) const = 0;

  Model model;
};

class MembraneElement : public Element {
 public:
  using Element::Element;

  [[nodiscard]] double energy(const linear::VertexField& x) const override {
    return membrane_energy(model.element_blocks(), model.materials(), x);
  }
  [[nodiscard]] linear::VertexField forces(const linear::VertexField& x) const override {
    linear::VertexField f = Eigen::Matrix3Xd::Zero(3, x.cols());
    add_membrane_forces(model.element_blocks(), model.materials(), {}, x, x, f);
    return f;
  }
  [[nodiscard]] Eigen::MatrixXd stiffness(const linear::VertexField& x, bool project) const override {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * x.cols(), 3 * x.cols());
    for_triangles(x, project, [&](const ElementBlock& block, std::size_t lane, const ElementMatrix& element) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          K.block<3, 3>(3 * block.vertex[i][lane], 3 * block.vertex[j][lane]) +=
              element.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j));
        }
      }
    });
    return K;
  }
  // visit(block, lane, K) of every triangle with material.
  template <typename Visit>
  void for_triangles(const linear::VertexField& x, bool project, const Visit& visit) const {
    LaneFrames frames;
    ElementMatrix element;
    for (const ElementBlock& block : model.element_blocks()) {
      frames_at(block, x, frames);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if (block.area[lane] == 0.0) continue;
        const MembraneTangent tangent(block, lane, frames, model.materials());
        tangent.stiffness(tangent.stress(), 1.0, 1.0, project, element);
        visit(block, lane, element);
      }
    }
  }
};

class BendingElement : public Element {
 public:
  BendingElement(const mesh::TriangleMesh& mesh, const Material& material)
      : Element(mesh, material, MembraneLaw::kCorotational) {}

  [[nodiscard]] double energy(const linear::VertexField& x) const override {
    return bending_energy(model.bending().rows(), x);
  }
  [[nodiscard]] linear::VertexField forces(const linear::VertexField& x) const override {
    linear::VertexField f = Eigen::Matrix3Xd::Zero(3, x.cols());
    add_bending_forces(model.bending().rows(), x, f);
    return f;
  }
  [[nodiscard]] Eigen::MatrixXd stiffness(const linear::VertexField& x, bool /*project*/) const override {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * x.cols(), 3 * x.cols());
    for (int i = 0; i < model.bending().rows().num_rows(); ++i) {
      for (const BendingEntry& entry : model.bending().rows().row(i)) {
        K.block<3, 3>(3 * i, 3 * entry.column) = entry.value * Eigen::Matrix3d::Identity();
      }
    }
    return K;
  }
};

class AngleBendingElement : public Element {
 public:
  AngleBendingElement(const mesh::TriangleMesh& mesh, const Material& material)
      : Element(mesh, material, MembraneLaw::kCorotational) {
    model.bend_by_angles(mesh);
  }

  [[nodiscard]] double energy(const linear::VertexField& x) const override { return angles().energy(x); }
  [[nodiscard]] linear::VertexField forces(const linear::VertexField& x) const override {
    linear::VertexField f = Eigen::Matrix3Xd::Zero(3, x.cols());
    angles().add_forces(x, f);
    return f;
  }
  [[nodiscard]] Eigen::MatrixXd stiffness(const linear::VertexField& x, bool project) const override {
    TangentMatrix tangent;
    tangent.rebuild(model);
    linear::BlockMatrix& blocks = tangent.blocks();
    blocks.set_zero();
    angles().add_stiffness(x, {}, project, blocks);
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * x.cols(), 3 * x.cols());
    for (int i = 0; i < blocks.num_rows(); ++i) {
      for (int at = blocks.row_begin(i); at < blocks.row_end(i); ++at) {
        K.block<3, 3>(3 * i, 3 * blocks.column(at)) = blocks.block(at);
      }
    }
    return K;
  }
  [[nodiscard]] const AngleBending& angles() const { return *model.bending().angles(); }
};

}  // namespace kerf::fem
