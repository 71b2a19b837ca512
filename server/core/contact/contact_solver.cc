#include "server/core/contact/contact_solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "server/base/check.h"

namespace kerf::contact {

namespace {

using mesh::kVertexLanes;

constexpr double kNever = std::numeric_limits<double>::infinity();

// Two walls count as parallel if the squared sine of the angle between them is below this.  -
constexpr double kLeastSineSquared = 1.0e-6;

void stop_approach(const Eigen::Vector3d& n, Eigen::Vector3d& v) {
  v -= std::min(v.dot(n), 0.0) * n;
}

}  // namespace

void ContactSolver::set_colliders(std::span<const Collider> colliders) {
  colliders_.clear();
  colliders_.reserve(colliders.size());
  for (const Collider& collider : colliders) colliders_.emplace_back(collider);
  collider_due_.assign(colliders_.size(), kNever);
  due_.resize(start_thickness_.size() * colliders_.size());
}

void ContactSolver::reserve(std::int32_t num_vertices) {
  const std::size_t blocks = (static_cast<std::size_t>(num_vertices) + kVertexLanes - 1) / kVertexLanes;
  if (colliders_.empty() || blocks <= start_thickness_.size()) return;
  start_thickness_.resize(blocks);
  has_inside_.resize(blocks);
  due_.resize(blocks * colliders_.size());
  block_due_.resize(blocks);
  due_blocks_.resize(blocks);
}

void ContactSolver::begin(double thickness, std::span<const std::uint8_t> fixed, const linear::VertexField& x) {
  if (colliders_.empty()) return;
  const auto num_vertices = static_cast<std::size_t>(x.cols());
  KERF_CHECK(fixed.empty() || fixed.size() == num_vertices, "pin mask of another mesh");
  num_blocks_ = (num_vertices + kVertexLanes - 1) / kVertexLanes;
  KERF_CHECK(num_blocks_ <= start_thickness_.size(), "reserve() was called for as many vertices");
  thickness_ = thickness;
  time_ = travel_ = 0.0;
  num_inside_ = 0;
  Eigen::Array3d low = Eigen::Array3d::Constant(kNever);
  Eigen::Array3d high = -low;
  for (std::size_t b = 0; b < num_blocks_; ++b) {
    for (std::size_t l = 0; l < kVertexLanes; ++l) {
      const std::size_t v = b * kVertexLanes + l;
      const bool is_free = v < num_vertices && (fixed.empty() || fixed[v] == 0);
      start_thickness_[b][l] = is_free ? thickness : -kNever;
      if (!is_free) continue;
      low = low.min(x.col(static_cast<Eigen::Index>(v)).array());
      high = high.max(x.col(static_cast<Eigen::Index>(v)).array());
    }
  }
  std::fill_n(has_inside_.begin(), num_blocks_, std::uint8_t{0});
  std::fill_n(block_due_.begin(), num_blocks_, kNever);
  const double radius = 0.5 * (high - low).matrix().norm();
  if (!(radius >= 0.0)) return;  // no vertex is free
  for (std::size_t c = 0; c < colliders_.size(); ++c) {
    const double distance = colliders_[c].query(0.5 * (low + high).matrix()).distance;
    collider_due_[c] = distance - radius - thickness - kTouching;
    if (!(collider_due_[c] > 0.0)) find_all_gaps(c, x);
  }
}

void ContactSolver::find_all_gaps(std::size_t collider, const linear::VertexField& x) {
  const auto num_vertices = static_cast<std::size_t>(x.cols());
  collider_due_[collider] = kNever;
  mesh::VertexLanes::Lanes gaps;
  for (std::size_t b = 0; b < num_blocks_; ++b) {
    const std::size_t first = b * kVertexLanes;
    const std::size_t count = std::min(kVertexLanes, num_vertices - first);
    for (std::size_t l = 0; l < count; ++l) {
      const auto v = static_cast<Eigen::Index>(first + l);
      for (std::size_t k = 0; k < 3; ++k) vertices_.x[k][l] = x(static_cast<Eigen::Index>(k), v);
    }
    find_gaps(colliders_[collider], start_thickness_[b], vertices_, gaps);
    double least = kNever;
    for (std::size_t l = 0; l < count; ++l) {
      least = std::min(least, gaps[l]);
      if (gaps[l] >= -kTouching || gaps[l] == -kNever) continue;
      has_inside_[b] = 1;
      const bool is_counted = start_thickness_[b][l] < -thickness_;
      start_thickness_[b][l] += gaps[l];
      if (!is_counted && start_thickness_[b][l] < -thickness_) ++num_inside_;
    }
    due(collider, b) = has_inside_[b] != 0 ? -kNever : least - kTouching;
    block_due_[b] = std::min(block_due_[b], due(collider, b));
  }
}

double ContactSolver::thickness(std::size_t v) const {
  return std::min(start_thickness_[v / kVertexLanes][v % kVertexLanes] + kExitSpeed * time_, thickness_);
}

void ContactSolver::set_block_due(std::size_t block) {
  double first = kNever;
  for (std::size_t c = 0; c < colliders_.size(); ++c) {
    if (collider_due_[c] == kNever) first = std::min(first, due(c, block));
  }
  block_due_[block] = first;
}

std::span<const std::int32_t> ContactSolver::find_due_blocks(double dt, double travel) {
  time_ += dt;
  travel_ += travel;
  std::size_t found = 0;
  for (std::size_t c = 0; c < colliders_.size(); ++c) {
    if (collider_due_[c] == kNever || collider_due_[c] >= travel_) continue;
    collider_due_[c] = kNever;
    for (std::size_t b = 0; b < num_blocks_; ++b) block_due_[b] = due(c, b) = -kNever;
  }
  for (std::size_t b = 0; b < num_blocks_; ++b) {
    if (block_due_[b] < travel_) due_blocks_[found++] = static_cast<std::int32_t>(b);
  }
  if (found > 0) ++counters_.phases;
  counters_.blocks += static_cast<std::int64_t>(found);
  return {due_blocks_.data(), found};
}

bool ContactSolver::push_out_of_all(std::size_t block, const ThicknessLanes& thickness, mesh::VertexLanes& vertices,
                                    std::uint32_t& pushed) {
  bool is_deep = false;
  for (std::size_t c = 0; c < colliders_.size(); ++c) {
    const bool is_clear = c == last_pushing_ || collider_due_[c] != kNever || due(c, block) >= travel_;
    if (is_clear) continue;
    const LanePush push = push_out(colliders_[c], thickness, vertices);
    due(c, block) = travel_ + push.least_gap - kTouching;
    if (push.pushed == 0) continue;
    last_pushing_ = push.residual > kTouching ? colliders_.size() : c;
    pushed |= push.pushed;
    counters_.contacts += std::popcount(push.pushed);
    is_deep = is_deep || push.deepest > kTouching;
    for (std::size_t other = 0; other < colliders_.size(); ++other) {
      if (other != c && collider_due_[other] == kNever) due(other, block) -= push.farthest;
    }
  }
  return is_deep;
}

std::uint32_t ContactSolver::resolve(std::int32_t block, mesh::VertexLanes& vertices) {
  const auto b = static_cast<std::size_t>(block);
  const bool has_inside = has_inside_[b] != 0;
  ThicknessLanes thickness = start_thickness_[b];
  if (has_inside) {
    for (double& each : thickness) each = std::min(each + kExitSpeed * time_, thickness_);
  }
  last_pushing_ = colliders_.size();
  std::uint32_t pushed = 0;
  bool is_deep = push_out_of_all(b, thickness, vertices, pushed);
  std::uint32_t pushed_again = 0;
  for (int pass = 1; pass < kPasses && is_deep; ++pass) {
    pushed_again = 0;
    is_deep = push_out_of_all(b, thickness, vertices, pushed_again);
    pushed |= pushed_again;
  }
  if (is_deep && colliders_.size() > 1 && pushed_again != 0) {
    for (std::size_t l = 0; l < kVertexLanes; ++l) {
      if ((pushed_again >> l & 1U) == 0) continue;
      Eigen::Vector3d x(vertices.x[0][l], vertices.x[1][l], vertices.x[2][l]);
      Eigen::Vector3d v(vertices.v[0][l], vertices.v[1][l], vertices.v[2][l]);
      leave_notch(thickness[l], x, v);
      for (std::size_t k = 0; k < 3; ++k) {
        vertices.x[k][l] = x[static_cast<Eigen::Index>(k)];
        vertices.v[k][l] = v[static_cast<Eigen::Index>(k)];
      }
    }
  }
  if (has_inside || pushed_again != 0) {
    for (std::size_t c = 0; c < colliders_.size(); ++c) due(c, b) = -kNever;
  }
  set_block_due(b);
  return pushed;
}

void ContactSolver::resolve(double dt, const linear::VertexField& x_before, linear::VertexField& x,
                            linear::VertexField& v) {
  if (colliders_.empty()) return;
  KERF_CHECK(x.cols() == v.cols() && x.cols() == x_before.cols(), "positions and velocities of different meshes");
  const double travel = std::sqrt((x - x_before).colwise().squaredNorm().maxCoeff());
  for (const std::int32_t block : find_due_blocks(dt, travel)) {
    const Eigen::Index first = block * static_cast<Eigen::Index>(kVertexLanes);
    const Eigen::Index count = std::min<Eigen::Index>(kVertexLanes, x.cols() - first);
    for (Eigen::Index l = 0; l < count; ++l) {
      for (Eigen::Index k = 0; k < 3; ++k) {
        const auto to = static_cast<std::size_t>(k);
        vertices_.x[to][static_cast<std::size_t>(l)] = x(k, first + l);
        vertices_.v[to][static_cast<std::size_t>(l)] = v(k, first + l);
        vertices_.before[to][static_cast<std::size_t>(l)] = x_before(k, first + l);
      }
    }
    const std::uint32_t pushed = resolve(block, vertices_);
    for (Eigen::Index l = 0; l < count; ++l) {
      if ((pushed >> l & 1U) == 0) continue;
      for (Eigen::Index k = 0; k < 3; ++k) {
        x(k, first + l) = vertices_.x[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)];
        v(k, first + l) = vertices_.v[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)];
      }
    }
  }
}

void ContactSolver::leave_notch(double thickness, Eigen::Vector3d& x, Eigen::Vector3d& v) const {
  for (int round = 0; round < kNotchRounds; ++round) {
    const Penetration first = deepest(thickness, x);
    if (first.collider == nullptr) return;
    x += first.depth * first.normal;
    stop_approach(first.normal, v);
    const Penetration second = deepest(thickness, x);
    if (second.collider == nullptr) return;
    // Moves the vertex along the first surface until it is out of the second.
    const Eigen::Vector3d along = second.normal - second.normal.dot(first.normal) * first.normal;
    const double sine_squared = along.squaredNorm();
    if (sine_squared < kLeastSineSquared) return;
    x += second.depth / sine_squared * along;
    stop_approach(second.normal, v);
    if (v.dot(first.normal) < 0.0) {  // The impulse at one wall sends it into the other, so only motion along both
                                      // walls stays.
      v -= v.dot(along) / sine_squared * along;
      v -= v.dot(first.normal) * first.normal;
    }
  }
}

ContactSolver::Penetration ContactSolver::deepest(double thickness, const Eigen::Vector3d& x) const {
  Penetration found;
  found.depth = kTouching;
  for (const PreparedCollider& collider : colliders_) {
    const Proximity near = collider.query(x);
    const double depth = thickness - near.distance;
    if (depth > found.depth) found = {&collider, depth, near.normal};
  }
  return found;
}

}  // namespace kerf::contact
