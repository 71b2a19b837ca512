// Members of LeapfrogSweep that set up the constants of a model.
#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

#include "server/core/fem/leapfrog/leapfrog_sweep.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

// Constants of a slot, with its corners in the order of turned_triangle(); all 0 for kNone.
struct TurnedConstants {
  std::array<std::array<double, 2>, 3> g{};  // 1/m, shape gradient of each corner
  double area = 0.0;                         // m^2
};

TurnedConstants turned_constants(const Model& model, TriangleId slot) {
  TurnedConstants turned;
  if (slot == mesh::kNone) return turned;
  const auto s = static_cast<std::size_t>(slot);
  const ElementBlock& block = model.element_blocks()[s / kLanes];
  const std::size_t from = s % kLanes;
  const std::size_t first = turned_triangle(block, from).first;
  for (std::size_t c = 0; c < 2; ++c) {
    const std::array<double, 3> g{-block.g1[c][from] - block.g2[c][from], block.g1[c][from], block.g2[c][from]};
    for (std::size_t k = 0; k < 3; ++k) turned.g[k][c] = g[(first + k) % 3];
  }
  turned.area = block.area[from];
  return turned;
}

template <typename T>
void set_triangle(const Model& model, TriangleId slot, double unit, TriangleLanes<T>& to, std::size_t l) {
  const TurnedConstants turned = turned_constants(model, slot);
  for (std::size_t c = 0; c < 2; ++c) {
    to.g1[c].lane[l] = static_cast<T>(unit * turned.g[1][c]);
    to.g2[c].lane[l] = static_cast<T>(unit * turned.g[2][c]);
  }
  to.minus_area.lane[l] = static_cast<T>(-turned.area / unit);
}

// Edge k is as long as twice the area times the gradient of the opposite corner.
template <typename T>
void set_edges(const Model& model, TriangleId slot, double unit, EdgeLanes<T>& to, std::size_t l) {
  // Both ends of edge k, and the corner opposite it.
  constexpr std::array<std::array<std::size_t, 3>, 3> kEnds{{{0, 1, 2}, {0, 2, 1}, {1, 2, 0}}};
  const TurnedConstants turned = turned_constants(model, slot);
  Eigen::Matrix3d N;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [a, b, opposite] = kEnds[k];
    const Eigen::Vector2d ga(turned.g[a][0], turned.g[a][1]);
    const Eigen::Vector2d gb(turned.g[b][0], turned.g[b][1]);
    N.col(static_cast<Eigen::Index>(k)) = -Eigen::Vector3d(ga[0] * gb[0], ga[1] * gb[1], ga[0] * gb[1] + ga[1] * gb[0]);
    const double height_inverse = std::hypot(turned.g[opposite][0], turned.g[opposite][1]);
    const double length = 2.0 * turned.area * height_inverse / unit;
    to.length_squared[k].lane[l] = static_cast<T>(length * length);
  }
  const Eigen::Matrix3d C = slot == mesh::kNone ? Eigen::Matrix3d::Zero() : model.elements().law(slot).membrane;
  const Eigen::Matrix3d H = 0.5 * turned.area * N.transpose() * C * N;
  const std::array<double, 6> entries{H(0, 0), H(1, 1), H(2, 2), H(0, 1), H(0, 2), H(1, 2)};
  const double cube = unit * unit * unit;
  for (std::size_t k = 0; k < entries.size(); ++k) to.stiffness[k].lane[l] = static_cast<T>(cube * entries[k]);
}

template <typename T>
void scale(linear::Lanes16<T>& lanes, T by) {
  for (T& value : lanes.lane) value *= by;
}
template <typename T>
void change_unit(TriangleLanes<T>& triangles, T by) {
  for (std::size_t c = 0; c < 2; ++c) {
    scale(triangles.g1[c], by);
    scale(triangles.g2[c], by);
  }
  scale(triangles.minus_area, 1 / by);
}
template <typename T>
void change_unit(EdgeLanes<T>& edges, T by) {
  // Scales in several factors: the cube of a unit may be too small for floats even if the result is not.
  for (linear::Lanes16<T>& length_squared : edges.length_squared) {
    for (int i = 0; i < 2; ++i) scale(length_squared, 1 / by);
  }
  for (linear::Lanes16<T>& stiffness : edges.stiffness) {
    for (int i = 0; i < 3; ++i) scale(stiffness, by);
  }
}

}  // namespace

template <typename T>
template <typename Set>
void LeapfrogSweep<T>::for_arrays(const Model& model, const MembraneLayout& layout, const Set& set) {
  const std::size_t n = layout.num_blocks();
  const auto reach = static_cast<std::size_t>(*std::max_element(layout.offsets().begin(), layout.offsets().end()));
  const std::size_t num_irregular = layout.lanes().size() / linear::kBlockLanes;
  pad_ = (reach + linear::kBlockLanes - 1) / linear::kBlockLanes;
  const std::size_t ring = std::bit_ceil(pad_ + std::min(2 * kQuadBlocksAhead, n));
  for (std::size_t c = 0; c < 3; ++c) {
    set(x_[c], n + 6 * pad_ + 1);
    set(v_[c], n + pad_ + 1);
    set(remainder_[c], std::is_same_v<T, float> ? n : 0);
    set(v_remainder_[c], std::is_same_v<T, float> ? n : 0);
    set(mobility_[c], n);
    for (Field<T>& force : quad_force_) set(force[c], reach > 0 ? ring + 1 : 0);
  }
  set(takes_part_, linear::kBlockLanes * n);
  const bool is_green = model.materials().membrane_law() == MembraneLaw::kGreen;
  set(quads_, reach > 0 && !is_green ? 2 * n : 0);
  set(quad_edges_, reach > 0 && is_green ? 2 * n : 0);
  set(irregular_edges_, is_green ? num_irregular : 0);
  set(quads_before_, reach > 0 ? 2 * n : 0);
  set(irregular_, num_irregular);
  const bool has_displacements = std::is_same_v<T, float> && !is_green;
  set(quad_start_, has_displacements && reach > 0 ? 2 * n : 0);
  set(irregular_start_, has_displacements ? num_irregular : 0);
  set(corner_x_, 4 * n);
  for (std::vector<linear::Lanes16<Position>>& x : bending_x_) set(x, n + 2);
  set(bending_fours_, 4 * n);
  set(corner_force_, 1 + 12 * num_irregular);
  set(gathered_, 4 * n);
  set(extra_, 4 * n);
  set(contact_.blocks, n);
  set(contact_.before, n);
  const bool has_several = !model.materials().has_one();
  set(quad_laws_, has_several && reach > 0 ? 2 * n : 0);
  set(irregular_laws_, has_several ? num_irregular : 0);
  set(mass_damping_, model.materials().has_one_mass_damping() ? 0 : n);
}

template <typename T>
void LeapfrogSweep<T>::resize(const Model& model, const MembraneLayout& layout) {
  layout_ = &layout;
  for_arrays(model, layout, [](auto& array, std::size_t size) { array.resize(size); });
  if (model.materials().has_bending()) bending_.resize(layout.num_vertices());
  if (std::is_same_v<T, float>) {
    start_.resize(static_cast<Eigen::Index>(linear::kBlockLanes * layout.num_blocks()));
    bending_start_.resize(layout.num_vertices());
    const auto n = static_cast<std::size_t>(layout.num_vertices());
    if (extents_.capacity() < n) extents_.reserve(n + n / 4);
    if (piece_of_.capacity() < n) piece_of_.reserve(n + n / 4);
  }
  has_cluster_.resize(inertia_->empty() ? 0 : layout.num_blocks());
  cluster_values_.resize(inertia_->largest() / 4 + 1);
  contact_.reserve(*inertia_);
}

template <typename T>
template <typename U>
void LeapfrogSweep<T>::reserve(const Model& model, const MembraneLayout& layout, const LeapfrogSweep<U>& like) {
  for_arrays(model, layout, [](auto& array, std::size_t size) {
    array.clear();
    if (array.capacity() < size) array.reserve(size + size / 4);
  });
  bending_.clear();
  bending_.make_room_as(like.bending_);
  has_cluster_.reserve(like.has_cluster_.size());
  cluster_values_.reserve(like.cluster_values_.size());
  contact_.reserve(*like.inertia_);
}

template <typename T>
void LeapfrogSweep<T>::rebuild(const Model& model, const MembraneLayout& layout, const LocalInertia& inertia) {
  inertia_ = &inertia;
  piece_of_.clear();
  resize(model, layout);
  fine_.gradient = flattest(model);
  fine_.place_of_lane.clear();
  fine_.lanes.clear();
  const auto num_lanes = static_cast<VertexId>(linear::kBlockLanes * layout.num_blocks());
  for (VertexId v = 0; !quads_before_.empty() && v < num_lanes; ++v) set_quads(model, layout, v);
  for (std::size_t lane = 0; lane < layout.lanes().size(); ++lane) set_lane(model, layout, lane);
  set_fine_constants(model, layout);
  bending_.clear();
  if (!model.materials().has_bending()) return;
  bending_.resize(layout.num_vertices());
  for (std::size_t block = 0; block < layout.num_blocks(); ++block) bending_.set_block(model.bending().rows(), block);
}

template <typename T>
void LeapfrogSweep<T>::follow(const Model& model, const MembraneLayout& layout, const LocalInertia& inertia) {
  inertia_ = &inertia;
  piece_of_.clear();
  resize(model, layout);
  for (const VertexId v : layout.changed_quads()) {
    if (static_cast<std::size_t>(v) / linear::kBlockLanes < layout.num_blocks()) set_quads(model, layout, v);
  }
  for (const std::int32_t lane : layout.changed_lanes()) set_lane(model, layout, static_cast<std::size_t>(lane));
  set_fine_constants(model, layout);
  if (model.materials().has_bending()) follow_bending(model);
}

template <typename T>
void LeapfrogSweep<T>::follow_bending(const Model& model) {
  const std::size_t num_blocks = layout_->num_blocks();
  bending_blocks_.clear();
  bending_blocks_.resize(num_blocks);
  bending_blocks_.insert(static_cast<std::int32_t>(num_blocks) - 1);  // may have lost rows
  for (const VertexId v : model.changed_rows()) {
    bending_blocks_.insert(static_cast<std::int32_t>(static_cast<std::size_t>(v) / linear::kBlockLanes));
  }
  for (const std::int32_t block : bending_blocks_.members()) {
    bending_.set_block(model.bending().rows(), static_cast<std::size_t>(block));
  }
}

template <typename T>
void LeapfrogSweep<T>::set_quads(const Model& model, const MembraneLayout& layout, VertexId v) {
  const std::size_t block = static_cast<std::size_t>(v) / linear::kBlockLanes;
  for (int kind = 0; kind < 2; ++kind) {
    const std::size_t at = 2 * block + static_cast<std::size_t>(kind);
    const std::size_t l = static_cast<std::size_t>(v) % linear::kBlockLanes;
    if (quad_edges_.empty()) {
      set_triangle(model, layout.quad_slot(kind, v), unit_of_constants_, quads_[at], l);
    } else {
      set_edges(model, layout.quad_slot(kind, v), unit_of_constants_, quad_edges_[at], l);
    }
  }
}

template <typename T>
void LeapfrogSweep<T>::set_lane(const Model& model, const MembraneLayout& layout, std::size_t lane) {
  IrregularBlock<T>& block = irregular_[lane / linear::kBlockLanes];
  const std::size_t l = lane % linear::kBlockLanes;
  const TriangleId slot = layout.lanes()[lane];
  const bool is_fine = slot != mesh::kNone && model.elements().gradient(slot) > fine_.gradient;
  if constexpr (std::is_same_v<T, float>) {
    fine_.place_of_lane.resize(layout.lanes().size(), mesh::kNone);
    fine_.set_lane(static_cast<std::int32_t>(lane), is_fine);
  }
  const TriangleId of_constants = is_fine ? mesh::kNone : slot;
  if (irregular_edges_.empty()) {
    set_triangle(model, of_constants, unit_of_constants_, block.triangles, irregular_lane<T>(l));
  } else {
    set_edges(model, of_constants, unit_of_constants_, irregular_edges_[lane / linear::kBlockLanes],
              irregular_lane<T>(l));
  }
  std::array<VertexId, 3> vertices{0, 0, 0};
  if (slot != mesh::kNone) {
    const auto s = static_cast<std::size_t>(slot);
    vertices = turned_triangle(model.element_blocks()[s / kLanes], s % kLanes).vertices;
  }
  for (std::size_t k = 0; k < 3; ++k) block.from[k][l] = 4 * vertices[k];
}

template <typename T>
void LeapfrogSweep<T>::set_fine_constants(const Model& model, const MembraneLayout& layout) {
  if constexpr (!std::is_same_v<T, float>) return;
  const std::size_t num_blocks = (fine_.lanes.size() + linear::kBlockLanes - 1) / linear::kBlockLanes;
  const bool is_green = model.materials().membrane_law() == MembraneLaw::kGreen;
  fine_.unit = unit_of_constants_;
  fine_.blocks.assign(num_blocks, {});
  fine_.edges.assign(is_green ? num_blocks : 0, {});
  fine_.laws.assign(model.materials().has_one() ? 0 : num_blocks, {});
  fine_.slots.clear();
  fine_.places.clear();
  for (const std::int32_t lane : fine_.lanes) {
    fine_.slots.push_back(layout.lanes()[static_cast<std::size_t>(lane)]);
    for (int k = 0; k < 3; ++k) fine_.places.push_back(4 * corner_place(lane, k));
  }
  fine_.corner_force.assign(12 * num_blocks, {});
  fine_.forces.assign(4 * fine_.places.size(), 0.0F);
  fine_vertices_.clear();
  fine_vertices_.resize(static_cast<std::size_t>(layout.num_vertices()));
  for (std::size_t i = 0; i < fine_.slots.size(); ++i) {
    IrregularBlock<double>& block = fine_.blocks[i / linear::kBlockLanes];
    const std::size_t l = i % linear::kBlockLanes;
    if (is_green) {
      set_edges(model, fine_.slots[i], fine_.unit, fine_.edges[i / linear::kBlockLanes], l);
    } else {
      set_triangle(model, fine_.slots[i], fine_.unit, block.triangles, l);
    }
    const auto s = static_cast<std::size_t>(fine_.slots[i]);
    const std::array<VertexId, 3> vertices = turned_triangle(model.element_blocks()[s / kLanes], s % kLanes).vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      fine_vertices_.insert(vertices[k]);
      block.from[k][l] = 4 * fine_vertices_.place(vertices[k]);
    }
  }
  fine_.vertices.assign(fine_vertices_.members().begin(), fine_vertices_.members().end());
  fine_.corner_x.assign(fine_.vertices.size() / 4 + 1, {});
  coarsest_gradient_.reset();
}

template <typename T>
void LeapfrogSweep<T>::set_unit_of_constants() {
  if (unit_ == unit_of_constants_) return;
  const auto by = static_cast<T>(unit_ / unit_of_constants_);
  for (TriangleLanes<T>& triangles : quads_) change_unit(triangles, by);
  for (IrregularBlock<T>& block : irregular_) change_unit(block.triangles, by);
  for (EdgeLanes<T>& edges : quad_edges_) change_unit(edges, by);
  for (EdgeLanes<T>& edges : irregular_edges_) change_unit(edges, by);
  const double ratio = unit_ / fine_.unit;
  for (IrregularBlock<double>& block : fine_.blocks) change_unit(block.triangles, ratio);
  for (EdgeLanes<double>& edges : fine_.edges) change_unit(edges, ratio);
  unit_of_constants_ = fine_.unit = unit_;
}

template <typename T>
void LeapfrogSweep<T>::set_laws(const Model& model, const LeapfrogTerms& terms) {
  for (std::size_t v = 0; !mass_damping_.empty() && v < model.mass().size(); ++v) {
    mass_damping_[v / linear::kBlockLanes].lane[v % linear::kBlockLanes] =
        static_cast<T>(model.masses().damping(static_cast<VertexId>(v)));
  }
  const auto set = [&]<typename U>(TriangleId slot, LawLanes<U>& to, std::size_t l) {
    if (slot == mesh::kNone) return;
    const auto s = static_cast<std::size_t>(slot);
    const std::uint8_t material = model.element_blocks()[s / kLanes].material[s % kLanes];
    const std::array<double, 4> law = law_entries(model.materials()[material]);
    for (std::size_t k = 0; k < law.size(); ++k) to.value[k].lane[l] = static_cast<U>(law[k]);
    to.value[4].lane[l] = static_cast<U>(damping_of(terms.damping, material) / terms.h);
  };
  for (VertexId v = 0; !quad_laws_.empty() && v < layout_->num_vertices(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    for (const int kind : {0, 1}) {
      set(layout_->quad_slot(kind, v), quad_laws_[2 * (i / linear::kBlockLanes) + static_cast<std::size_t>(kind)],
          i % linear::kBlockLanes);
    }
  }
  for (std::size_t lane = 0; !irregular_laws_.empty() && lane < layout_->lanes().size(); ++lane) {
    set(layout_->lanes()[lane], irregular_laws_[lane / linear::kBlockLanes],
        irregular_lane<T>(lane % linear::kBlockLanes));
  }
  for (std::size_t i = 0; !fine_.laws.empty() && i < fine_.slots.size(); ++i) {
    set(fine_.slots[i], fine_.laws[i / linear::kBlockLanes], i % linear::kBlockLanes);
  }
}

template class LeapfrogSweep<float>;
template class LeapfrogSweep<double>;
template void LeapfrogSweep<double>::reserve(const Model& model, const MembraneLayout& layout,
                                             const LeapfrogSweep<float>& like);

}  // namespace kerf::fem
