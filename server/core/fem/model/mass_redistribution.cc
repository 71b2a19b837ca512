#include "server/core/fem/model/mass_redistribution.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "server/base/as_index.h"

namespace kerf::fem {
namespace {

using mesh::kNone;
using mesh::TriangleId;
using mesh::VertexId;

constexpr int kMaxRounds = 200;
constexpr double kLeastGain = 1.001;  // least factor by which a round must improve the worst mass / floor

// Calls visit(n, again) for each neighbour n of `vertex` at least once. If `again` is false, n has not been visited
// before.
template <typename Visit>
void visit_neighbours(const MassProblem& problem, VertexId vertex, const Visit& visit) {
  const auto neighbours = [&](TriangleId slot) {  // counter-clockwise
    const ElementBlock& block = problem.blocks[static_cast<std::size_t>(slot / kLanes)];
    const auto l = static_cast<std::size_t>(slot % kLanes);
    const std::size_t k = (block.vertex[1][l] == vertex ? 1U : 0U) + (block.vertex[2][l] == vertex ? 2U : 0U);
    return std::array<VertexId, 2>{block.vertex[k == 2 ? 0 : k + 1][l], block.vertex[k == 0 ? 2 : k - 1][l]};
  };
  // The triangles around a vertex form one run. Each neighbour comes first in one triangle and second in another,
  // except those at the two ends of an open run.
  VertexId ends = 0;
  for (const TriangleId slot : problem.incident_slots.row(vertex)) {
    const auto [first, second] = neighbours(slot);
    visit(first, false);
    ends ^= first ^ second;
  }
  if (ends == 0) return;
  for (const TriangleId slot : problem.incident_slots.row(vertex)) visit(neighbours(slot)[1], true);
}

// Diffusion within one domain. Vertices are numbered as in `members`.
class Diffusion {
 public:
  // `members` must be in canonical order: results depend on it.
  Diffusion(const MassProblem& problem, const linear::IndexSet& members) : is_light_(members.size()) {
    for (const VertexId v : members.members()) {
      mass_.push_back(problem.lumped[as_index(v)]);
      floor_.push_back(problem.floor[as_index(v)]);
      // Upper bound of the number of edges: a fan at the border has one edge more than triangles.
      degree_.push_back(static_cast<double>(problem.incident_slots.row(v).size() + 1));
      first_edge_.push_back(edges_.size());
      visit_neighbours(problem, v, [&](VertexId n, bool again) {
        if (!members.contains(n)) return;
        const auto edge = static_cast<std::size_t>(members.place(n));
        const auto first = edges_.begin() + static_cast<std::ptrdiff_t>(first_edge_.back());
        if (!again || std::find(first, edges_.end(), edge) == edges_.end()) edges_.push_back(edge);
      });
    }
    first_edge_.push_back(edges_.size());
    for (std::size_t i = 0; i < mass_.size(); ++i) note(i);
  }

  [[nodiscard]] const std::vector<double>& run() {
    double worst = worst_fullness();
    for (int round = 0; round < kMaxRounds && worst < kMassReached; ++round) {
      pull();
      const double better = worst_fullness();
      if (better < worst * kLeastGain) break;
      worst = better;
    }
    return mass_;
  }

 private:
  struct Flow {
    std::size_t from;
    std::size_t to;
    double mass;  // kg
  };

  [[nodiscard]] double fullness(std::size_t i) const { return mass_[i] / floor_[i]; }

  [[nodiscard]] double worst_fullness() const {
    double worst = 1.0;
    for (const std::size_t i : light_) worst = std::min(worst, fullness(i));
    return worst;
  }

  // Makes one round. An edge carries at most 1 / (2 degree) of the mass of its donor, so nothing becomes negative.
  void pull() {
    flows_.clear();
    for (const std::size_t i : light_) {
      const double own = fullness(i);
      if (own >= 1.0) continue;
      for (std::size_t e = first_edge_[i]; e < first_edge_[i + 1]; ++e) {
        const std::size_t donor = edges_[e];
        const double difference = fullness(donor) - own;
        if (difference <= 0.0) continue;
        const double floor = std::min(floor_[donor], floor_[i]);
        flows_.push_back({donor, i, difference * floor / (2.0 * std::max(degree_[donor], degree_[i]))});
      }
    }
    for (const Flow& flow : flows_) {
      mass_[flow.from] -= flow.mass;
      mass_[flow.to] += flow.mass;
    }
    for (const Flow& flow : flows_) note(flow.from);
  }

  void note(std::size_t i) {
    if (is_light_[i] || mass_[i] >= floor_[i]) return;
    is_light_[i] = true;
    light_.push_back(i);
  }

  std::vector<double> mass_, floor_, degree_;
  std::vector<std::size_t> first_edge_, edges_;  // edges within the domain, a row a vertex
  std::vector<bool> is_light_;
  std::vector<std::size_t> light_;  // vertices that are or were below their floor, in the order they became so
  std::vector<Flow> flows_;
};

}  // namespace

MassTile mass_tile(const mesh::EdgeLengths& lengths, const Eigen::Vector2d& at) {
  const double length = lengths.at(at);
  const double side = kMassTileEdges * length;
  // Edge lengths are the mean times a power of two. The exponent distinguishes tiles of different widths.
  const auto width = static_cast<std::uint64_t>(std::ilogb(length / lengths.mean * std::sqrt(2.0)) & 0xff);
  const Eigen::Vector2d place = (at - lengths.bounds.min()) / side;
  MassTile tile;
  for (std::size_t grid = 0; grid < tile.size(); ++grid) {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << 28) - 1;
    const double shift = grid == 0 ? 0.0 : 0.5;
    const auto column = static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(place.x() + shift))) & kMask;
    const auto row = static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(place.y() + shift))) & kMask;
    tile[grid] = width << 56 | column << 28 | row;
  }
  return tile;
}

double corner_stiffness(double gx, double gy, double area, const Eigen::Matrix3d& C) {
  return area *
         (C(0, 0) * gx * gx + C(1, 1) * gy * gy + C(2, 2) * (gx * gx + gy * gy) + 2.0 * (C(0, 2) + C(1, 2)) * gx * gy);
}

// Frees a domain, if there is one that is not free already, and adds its members to the region.
void MassPass::dissolve(std::int32_t domain) {
  if (domain == kNone || domains_[static_cast<std::size_t>(domain)].empty()) return;
  std::vector<VertexId>& members = domains_[static_cast<std::size_t>(domain)];
  for (const VertexId member : members) {
    if (as_index(member) >= domain_of_.size()) continue;
    domain_of_[as_index(member)] = kNone;
    region_.insert(member);
  }
  members.clear();
  free_domains_.push_back(domain);
}

// Fills reach_ with vertices within kReach edges, in the same tile, of the region's light vertices. Domains met on the
// way are dissolved and join the region. Returns false if that happened; the search must then be repeated.
bool MassPass::gather_reach(const MassProblem& problem) {
  reach_.clear();
  const std::size_t region_size = region_.size();
  for (const VertexId v : region_.members()) {
    if (problem.lumped[as_index(v)] < light_below_ * problem.floor[as_index(v)]) reach_.insert(v);
  }
  std::size_t begin = 0;
  for (int depth = 0; depth <= kReach; ++depth) {
    const std::size_t end = reach_.size();
    for (; begin < end; ++begin) {
      const VertexId v = reach_.members()[begin];
      visit_neighbours(problem, v, [&](VertexId n, bool /*again*/) {
        if (!share_tile(problem, v, n)) return;
        dissolve(domain_of_[as_index(n)]);
        if (depth < kReach) reach_.insert(n);
      });
    }
  }
  return region_.size() == region_size;
}

bool MassPass::share_tile(const MassProblem& problem, VertexId a, VertexId b) const {
  return problem.tiles[as_index(a)][grid_] == problem.tiles[as_index(b)][grid_];
}

void MassPass::store_domain(std::vector<VertexId> members) {
  auto domain = static_cast<std::int32_t>(domains_.size());
  if (free_domains_.empty()) {
    domains_.emplace_back();
  } else {
    domain = free_domains_.back();
    free_domains_.pop_back();
  }
  for (const VertexId v : members) domain_of_[as_index(v)] = domain;
  domains_[static_cast<std::size_t>(domain)] = std::move(members);
}

std::span<const VertexId> MassPass::update(const MassProblem& problem, std::span<const VertexId> touched,
                                           std::span<double> mass) {
  domain_.resize(mass.size());
  for (linear::IdSet* set : {&region_, &reach_, &parted_}) {
    set->clear();
    set->resize(mass.size());
  }
  // Numbers of the domains (see MassPass) that have vertices which the sheet no longer has.
  std::vector<std::int32_t> dropped;
  for (std::size_t v = mass.size(); v < domain_of_.size(); ++v) dropped.push_back(domain_of_[v]);
  domain_of_.resize(mass.size(), kNone);
  for (const std::int32_t domain : dropped) dissolve(domain);
  for (const VertexId v : touched) region_.insert(v);
  for (const VertexId v : touched) dissolve(domain_of_[as_index(v)]);
  while (!gather_reach(problem)) {
  }
  for (const VertexId v : reach_.members()) region_.insert(v);
  mass_before_.clear();
  for (const VertexId v : region_.members()) {
    mass_before_.push_back(mass[as_index(v)]);
    mass[as_index(v)] = problem.lumped[as_index(v)];
  }
  // Connected parts of the reached set.
  for (const VertexId first : reach_.members()) {
    if (!parted_.insert(first)) continue;
    std::vector<VertexId> members{first};
    for (std::size_t i = 0; i < members.size(); ++i) {
      visit_neighbours(problem, members[i], [&](VertexId n, bool /*again*/) {
        if (reach_.contains(n) && share_tile(problem, first, n) && parted_.insert(n)) members.push_back(n);
      });
    }
    std::sort(members.begin(), members.end());
    domain_.clear();
    for (const VertexId v : members) domain_.insert(v);
    Diffusion diffusion(problem, domain_);
    const std::vector<double>& result = diffusion.run();
    for (std::size_t i = 0; i < members.size(); ++i) mass[as_index(members[i])] = result[i];
    store_domain(std::move(members));
  }
  return region_.members();
}

std::span<const VertexId> MassRedistribution::update(const MassProblem& problem, std::span<const VertexId> touched,
                                                     std::span<double> mass) {
  between_.resize(mass.size(), 0.0);
  const std::span<const VertexId> looked_at = first_.update(problem, touched, between_);
  touched_again_.assign(touched.begin(), touched.end());
  for (std::size_t i = 0; i < looked_at.size(); ++i) {
    if (between_[as_index(looked_at[i])] != first_.mass_before()[i]) touched_again_.push_back(looked_at[i]);
  }
  const MassProblem left{problem.incident_slots, problem.blocks, between_, problem.floor, problem.tiles};
  return second_.update(left, touched_again_, mass);
}

}  // namespace kerf::fem
