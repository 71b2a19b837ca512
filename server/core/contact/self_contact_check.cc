// Members of SelfContact that check the motion since the last phase, and put right what passed through.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "server/core/contact/self_contact.h"

namespace kerf::contact {

using mesh::VertexId;

namespace {

constexpr int kRepairRounds = 6;
constexpr int kZoneRounds = 100;
constexpr double kUnchecked = 2e-8;  // m, pairs that were nearer have no direction; they are checked once they part

// Returns the distance (m) that a pair must keep which was `distance` apart. Gaps never shrink to nothing.
double gap_to_keep(double distance, const FeaturePair& pair) {
  return std::max(0.1 * distance, std::min(pair.least, 0.999 * distance));
}

}  // namespace

void SelfContact::check(linear::VertexField& x, linear::VertexField& v) {
  for (int round = 0; find_failed(x, round == 0); ++round) {
    if (round >= kRepairRounds + kZoneRounds) {
      counters_.unsettled += static_cast<std::int64_t>(failed_.size());
      break;
    }
    if (round < kRepairRounds) {
      counters_.repairs += static_cast<std::int64_t>(failed_.size());
      for (const std::size_t p : failed_) repair(p, x, v);
    } else {
      counters_.zones += static_cast<std::int64_t>(failed_.size());
      move_zones(x, v);
    }
    // Vertices that were moved may have met others than the list has.
    find_strayed_of_shifted(x);
    if (!strayed_.empty()) find_again(x);
  }
  for (const VertexId i : zoned_) {
    zone_[static_cast<std::size_t>(i)] = i;
    is_zoned_[static_cast<std::size_t>(i)] = 0;
  }
  zoned_.clear();
}

void SelfContact::move(VertexId v, const Eigen::Vector3d& to, linear::VertexField& x) {
  const auto i = static_cast<std::size_t>(v);
  path_[i] += static_cast<float>((to - x.col(v)).norm());
  x.col(v) = to;
  mark(v);
  if (is_shifted_[i] == 0) shifted_.push_back(v);
  is_shifted_[i] = 1;
}

bool SelfContact::find_failed(const linear::VertexField& x, bool is_first) {
  failed_.clear();
  if (is_first) {
    find_due(list_.vertices, pair_ways(), std::span(list_.safe).first(list_.size()), due_, due_ways_);
    // The last phase left its positions in x_float_.
    if (!is_float_set_) x_float_.set(x_then_, tree_.features().vertices);
    std::swap(x_float_, x_then_float_);
    x_float_.set(x, tree_.features().vertices);
    is_float_set_ = true;
  } else {
    x_float_.update(x, shifted_);
    if (!std::exchange(is_indexed_, true)) list_index_.set(list_.vertices, list_.size(), path_.size());
    list_index_.find(shifted_, due_);
    std::erase_if(due_, [this](std::int32_t index) {
      const auto p = static_cast<std::size_t>(index);
      return way_of(p) < list_.safe[p];
    });
  }
  unseparated_.clear();
  for_due_kinds([this](const PairSelection& pairs, std::size_t) {
    keep_unseparated(pairs, list_.least, x_then_float_, x_float_, unseparated_);
  });
  for (const std::int32_t index : unseparated_) {
    const auto p = static_cast<std::size_t>(index);
    const FeaturePair& pair = list_.pairs[p];
    const Separation then = separation_then(p);
    if (then.distance < kUnchecked) continue;
    const PairPositions to = positions_of(pair, x);
    const double gap = gap_to_keep(then.distance, pair);
    if (gap_along(pair.num_a(), then.normal, to) > gap) continue;
    if (stays_apart(pair.kind, positions_of(pair, x_then_), to, gap)) continue;
    failed_.push_back(p);
  }
  for (const VertexId v : shifted_) is_shifted_[static_cast<std::size_t>(v)] = 0;
  shifted_.clear();
  return !failed_.empty();
}

void SelfContact::repair(std::size_t p, linear::VertexField& x, linear::VertexField& v) {
  const FeaturePair& pair = list_.pairs[p];
  const Separation then = separation_then(p);
  const double gap =
      1.001 * std::max({gap_to_keep(then.distance, pair), std::min(0.5 * then.distance, 0.1 * thickness_),
                        std::min(1.5 * then.distance, pair.least)});
  const bool is_shared =
      std::any_of(pair.vertices.begin(), pair.vertices.end(), [this](VertexId i) { return response_.is_shared(i); });
  is_shared ? move_apart_shared(pair, then, gap, x) : move_apart(pair, then, gap, x);
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) u += then.weights[i] * v.col(pair.vertices[i]);
  const double closing = -then.normal.dot(u);
  const double mobility = response_.mobility(pair.vertices, then.weights, then.normal);
  if (closing > 0.0 && mobility > 0.0) apply(pair, then, closing / mobility * then.normal, v);
}

// Moves both sides to their sides of a plane perpendicular to the normal of then. The place of the plane follows from
// the momentum, which does not change.
void SelfContact::move_apart(const FeaturePair& pair, const Separation& then, double gap, linear::VertexField& x) {
  const std::size_t num_a = pair.num_a();
  std::array<double, 4> height{}, mass{};
  for (std::size_t i = 0; i < 4; ++i) {
    height[i] =
        then.normal.dot(x.col(pair.vertices[i]) - x_then_.col(pair.vertices[3])) + (i < num_a ? -0.5 : 0.5) * gap;
    const double inverse = response_.inverse_mass(pair.vertices[i]);
    mass[i] = inverse > 0.0 ? 1.0 / inverse : std::numeric_limits<double>::infinity();
  }
  // Finds the place at which as much momentum goes to a as to b; the balance falls as the plane rises.
  double low = *std::min_element(height.begin(), height.end()), high = *std::max_element(height.begin(), height.end());
  const auto balance = [&](double place) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double way = i < num_a ? std::max(place - height[i], 0.0) : std::min(place - height[i], 0.0);
      if (way != 0.0) sum += mass[i] * way;
    }
    return sum;
  };
  for (int k = 0; k < 60 && low < high; ++k) {
    const double middle = 0.5 * (low + high);
    (balance(middle) > 0.0 ? high : low) = middle;
  }
  const double place = 0.5 * (low + high);
  for (std::size_t i = 0; i < 4; ++i) {
    const VertexId vertex = pair.vertices[i];
    const double way = i < num_a ? std::max(place - height[i], 0.0) : std::min(place - height[i], 0.0);
    if (way == 0.0 || response_.inverse_mass(vertex) == 0.0) continue;
    move(vertex, x.col(vertex) + way * then.normal, x);
  }
}

// Pushes the two vertices apart that limit the gap, and all that share inertia with them, until the gap between both
// sides is `gap`. Points nearest then may be others: pushes on those would move a group that turned without an end.
void SelfContact::move_apart_shared(const FeaturePair& pair, const Separation& then, double gap,
                                    linear::VertexField& x) {
  constexpr int kMostPushes = 4;
  const std::size_t num_a = pair.num_a();
  for (int push = 0; push < kMostPushes; ++push) {
    std::array<double, 4> height{};
    for (std::size_t i = 0; i < 4; ++i) {
      height[i] = then.normal.dot(x.col(pair.vertices[i]) - x_then_.col(pair.vertices[3]));
    }
    const auto split = height.begin() + static_cast<std::ptrdiff_t>(num_a);
    const auto lowest = std::min_element(height.begin(), split), highest = std::max_element(split, height.end());
    const double lack = gap - (*lowest - *highest);
    if (!(lack > 0.0)) return;
    std::array<double, 4> weights{};
    weights[static_cast<std::size_t>(lowest - height.begin())] = 1.0;
    weights[static_cast<std::size_t>(highest - height.begin())] = -1.0;
    const double mobility = response_.mobility(pair.vertices, weights, then.normal);
    if (!(mobility > 0.0)) return;
    response_.push(pair.vertices, weights, lack / mobility * then.normal,
                   [&](VertexId vertex, const Eigen::Vector3d& way) { move(vertex, x.col(vertex) + way, x); });
  }
}

std::int32_t SelfContact::root(VertexId v) {
  while (zone_[static_cast<std::size_t>(v)] != v) v = zone_[static_cast<std::size_t>(v)];
  return v;
}

void SelfContact::add_to_zone(VertexId v, VertexId of) {
  const auto add = [&](VertexId i) {
    std::uint8_t& is_zoned = is_zoned_[static_cast<std::size_t>(i)];
    const bool is_new = is_zoned == 0;
    if (is_new) zoned_.push_back(i);
    is_zoned = 1;
    const std::int32_t a = root(of), b = root(i);
    zone_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    return is_new;
  };
  if (!add(v) || !response_.is_shared(v)) return;
  for (const VertexId i : response_.group_of(v)) add(i);
}

// Unites the vertices of failed pairs with their zones, and moves each zone by its mean displacement.
void SelfContact::move_zones(linear::VertexField& x, linear::VertexField& v) {
  constexpr double kHeld = 1e9;  // kg, of a vertex that is held
  for (const std::size_t p : failed_) {
    const std::array<VertexId, 4>& vertices = list_.pairs[p].vertices;
    for (const VertexId i : vertices) add_to_zone(i, vertices[0]);
  }
  const auto zone_of = [this](VertexId i) -> Zone& { return zones_[static_cast<std::size_t>(root(i))]; };
  for (const VertexId i : zoned_) zone_of(i) = Zone();
  for (const VertexId i : zoned_) {
    Zone& zone = zone_of(i);
    const double inverse = response_.inverse_mass(i), mass = inverse > 0.0 ? 1.0 / inverse : kHeld;
    zone.mass += mass;
    zone.way += mass * (x.col(i) - x_then_.col(i));
    zone.velocity += mass * v.col(i);
  }
  for (const VertexId i : zoned_) {
    if (response_.inverse_mass(i) == 0.0) continue;
    const Zone& zone = zone_of(i);
    v.col(i) = zone.velocity / zone.mass;
    move(i, x_then_.col(i) + zone.way / zone.mass, x);
  }
}

}  // namespace kerf::contact
