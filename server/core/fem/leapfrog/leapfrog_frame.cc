// Members of LeapfrogSweep that choose the origin and the unit of positions.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/core/fem/leapfrog/leapfrog_sweep.h"
#include "server/core/fem/leapfrog/leapfrog_vertices.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

// -, largest unit of positions over the edge length (kCoarsest), and over the height of any triangle (kCoarsestAcross).
// With larger units, strains of fixed-point positions are too coarse.
constexpr double kCoarsest = 1.0 / (1 << 20);
constexpr double kCoarsestAcross = 1e-5;
// -, travel of a sheet, in sizes of the sheet, for which fixed-point units leave room. Triangles too flat for such a
// unit become FineTriangles.
constexpr double kRoomToTravel = 2.0;

// Returns the mean edge length, m.
double edge_length(const Model& model, std::int64_t num_triangles) {
  return std::sqrt(2.0 * model.elements().area() / static_cast<double>(num_triangles));
}

// Returns the unit, m, for positions up to `reach` (m) from the origin.
double unit_of_positions(double reach, double edge) {
  constexpr double kUnits = 1 << 30;
  int exponent = 0;
  const double mantissa = std::frexp(std::max(reach, edge) / kUnits, &exponent);
  return std::ldexp(1.0, mantissa > 0.5 ? exponent : exponent - 1);
}

// -, allowance for travel, in sizes of the sheet, beyond that by its speed. A sheet that springs back gets faster.
constexpr double kSpring = 1.0;
// -, the same allowance for each piece. It is smaller because the only alternative is double precision.
constexpr double kSpringOfPieces = 0.25;

// Returns the distance (m) that vertices of a sheet or piece may travel in a step.
template <class Extent>
double travel_of(const Extent& extent, double spring, const LeapfrogTerms& terms, double duration) {
  return spring * extent.size() + 4.0 * duration * (extent.speed + duration * terms.gravity.norm());
}

}  // namespace

template <typename T>
bool LeapfrogSweep<T>::set_frame(const Model& model, const LeapfrogTerms& terms, double duration, const State& state) {
  speed_ = {};
  fastest_ = 0;
  touched_ = false;
  num_cluster_pushes_ = 0;
  is_by_pieces_ = false;
  if constexpr (!std::is_same_v<T, float>) return true;
  Extent all;
  for (VertexId v = 0; v < layout_->num_vertices(); ++v) {
    if (takes_part_[static_cast<std::size_t>(v)] != 0) all.add(state, v);
  }
  if (!(all.size() >= 0.0)) return true;  // nothing takes part
  const double edge = edge_length(model, layout_->num_triangles());
  const auto is_fine = [&] { return unit_ <= kCoarsest * edge && unit_ * coarsest_gradient(model) <= kCoarsestAcross; };
  origin_ = all.middle();
  if (is_by_displacements()) {
    // A vertex lying on a body falls by gravity for one substep and is stopped.
    const double hardly = std::max(all.speed, displacement_speed_) + terms.h * terms.gravity.norm();
    room_ = 4.0 * duration * hardly;
    unit_ = unit_of_positions(room_, 0.0);
    return is_fine();
  }
  room_ = travel_of(all, kSpring, terms, duration);
  unit_ = unit_of_positions(0.5 * all.size() + room_, edge);
  if (is_fine()) return true;
  // If pieces are far apart each gets an origin of its own, and then needs range only for itself.
  const double reach = set_frames_of_pieces(terms, duration, state);
  unit_ = unit_of_positions(reach, edge);
  return is_fine();
}

template <typename T>
double LeapfrogSweep<T>::set_frames_of_pieces(const LeapfrogTerms& terms, double duration, const State& state) {
  is_by_pieces_ = true;
  if (piece_of_.empty()) find_pieces();
  extents_.assign(piece_of_.size(), {});
  for (VertexId v = 0; v < layout_->num_vertices(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    if (takes_part_[i] != 0) extents_[static_cast<std::size_t>(piece_of_[i])].add(state, v);
  }
  double reach = 0.0;
  double half = 0.0;
  for (const Extent& piece : extents_) {
    if (!(piece.size() >= 0.0)) continue;
    half = std::max(half, 0.5 * piece.size());
    reach = std::max(reach, 0.5 * piece.size() + travel_of(piece, kSpringOfPieces, terms, duration));
  }
  room_ = reach - half;
  start_.setZero();
  for (std::size_t i = 0; i < piece_of_.size(); ++i) {
    const Extent& piece = extents_[static_cast<std::size_t>(piece_of_[i])];
    if (piece.size() >= 0.0) start_.col(static_cast<Eigen::Index>(i)) = piece.middle();
  }
  return reach;
}

template <typename T>
void LeapfrogSweep<T>::find_pieces() {
  piece_of_.resize(static_cast<std::size_t>(layout_->num_vertices()));
  std::iota(piece_of_.begin(), piece_of_.end(), 0);
  const auto root = [&](VertexId v) {
    while (piece_of_[static_cast<std::size_t>(v)] != v) {
      VertexId& above = piece_of_[static_cast<std::size_t>(v)];
      v = above = piece_of_[static_cast<std::size_t>(above)];
    }
    return v;
  };
  const auto join = [&](VertexId a, VertexId b) {
    const VertexId root_a = root(a);
    const VertexId root_b = root(b);
    piece_of_[static_cast<std::size_t>(std::max(root_a, root_b))] = std::min(root_a, root_b);
  };
  const QuadOffsets& offsets = layout_->offsets();
  for (VertexId v = 0; !quads_before_.empty() && v < layout_->num_vertices(); ++v) {
    for (const int kind : {0, 1}) {
      if (layout_->quad_slot(kind, v) == mesh::kNone) continue;
      for (const int corner : {kind, kind + 1}) join(v, v + offsets[static_cast<std::size_t>(corner)]);
    }
  }
  for (std::size_t lane = 0; lane < layout_->lanes().size(); ++lane) {
    if (layout_->lanes()[lane] == mesh::kNone) continue;
    const auto& from = irregular_[lane / linear::kBlockLanes].from;
    const std::size_t l = lane % linear::kBlockLanes;
    for (const std::size_t corner : {1, 2}) join(from[0][l] / 4, from[corner][l] / 4);
  }
  for (VertexId v = 0; v < layout_->num_vertices(); ++v) piece_of_[static_cast<std::size_t>(v)] = root(v);
}

template <typename T>
bool LeapfrogSweep<T>::may_hold(const Model& model) {
  const double edge = edge_length(model, model.num_slots());  // accurate enough for an estimate
  return unit_of_positions(1.5 * std::sqrt(model.elements().area()), edge) <= kCoarsest * edge;
}

template <typename T>
double LeapfrogSweep<T>::flattest(const Model& model) {
  if (!std::is_same_v<T, float>) return std::numeric_limits<double>::infinity();
  const double unit = unit_of_positions(1.5 * model.masses().built_extent(), model.masses().typical_edge_length());
  return kCoarsestAcross / (kRoomToTravel * unit);
}

template <typename T>
double LeapfrogSweep<T>::coarsest_gradient(const Model& model) {
  if (coarsest_gradient_) return *coarsest_gradient_;
  double coarsest = 0.0;
  const auto look_at = [&](mesh::TriangleId slot) {
    if (slot != mesh::kNone) coarsest = std::max(coarsest, model.elements().gradient(slot));
  };
  for (std::size_t lane = 0; lane < layout_->lanes().size(); ++lane) {
    if (fine_.place_of_lane[lane] == mesh::kNone) look_at(layout_->lanes()[lane]);
  }
  for (VertexId v = 0; !quads_before_.empty() && v < layout_->num_vertices(); ++v) {
    for (const int kind : {0, 1}) look_at(layout_->quad_slot(kind, v));
  }
  coarsest_gradient_ = coarsest;
  return coarsest;
}

template <typename T>
bool LeapfrogSweep<T>::stayed_inside(double duration) const {
  if constexpr (!std::is_same_v<T, float>) return true;
  const T fastest = std::max(fastest_, *std::max_element(speed_.lane.begin(), speed_.lane.end()));
  return duration * static_cast<double>(fastest) <= room_;
}

template bool LeapfrogSweep<float>::set_frame(const Model& model, const LeapfrogTerms& terms, double duration,
                                              const State& state);
template bool LeapfrogSweep<double>::set_frame(const Model& model, const LeapfrogTerms& terms, double duration,
                                               const State& state);
template bool LeapfrogSweep<float>::may_hold(const Model& model);
template bool LeapfrogSweep<double>::may_hold(const Model& model);
template double LeapfrogSweep<float>::flattest(const Model& model);
template double LeapfrogSweep<double>::flattest(const Model& model);
template double LeapfrogSweep<float>::coarsest_gradient(const Model& model);
template double LeapfrogSweep<double>::coarsest_gradient(const Model& model);
template bool LeapfrogSweep<float>::stayed_inside(double duration) const;
template bool LeapfrogSweep<double>::stayed_inside(double duration) const;

}  // namespace kerf::fem
