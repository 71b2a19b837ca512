#include "server/fem/mass_redistribution.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

constexpr int kMaxRounds = 200;
constexpr double kReached = 0.9;      // of the floor
constexpr double kLeastGain = 1.001;  // of the worst mass / floor, in a round, as a factor

// The vertices joined to `vertex` by an edge, ascending.
std::vector<VertexId> neighbours_of(VertexId vertex, const RowStore<TriangleId>& incident_slots,
                                    std::span<const ElementBlock> blocks) {
  std::vector<VertexId> neighbours;
  for (const TriangleId slot : incident_slots.row(vertex)) {
    const ElementBlock& block = blocks[static_cast<std::size_t>(slot / kLanes)];
    for (std::size_t k = 0; k < 3; ++k) neighbours.push_back(block.vertex[k][static_cast<std::size_t>(slot % kLanes)]);
  }
  std::sort(neighbours.begin(), neighbours.end());
  neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
  std::erase(neighbours, vertex);
  return neighbours;
}

// Vertices below their floor with their neighbours, by id; grows as donors fall below theirs.
class LightVertices {
 public:
  LightVertices(const RowStore<TriangleId>& incident_slots, std::span<const ElementBlock> blocks,
                std::span<const double> floor, std::span<double> mass)
      : incident_slots_(incident_slots), blocks_(blocks), floor_(floor), mass_(mass) {
    for (std::size_t i = 0; i < mass.size(); ++i) note(static_cast<VertexId>(i));
  }

  [[nodiscard]] double worst() const {
    double worst = 1.0;
    for (const auto& [vertex, neighbours] : light_) worst = std::min(worst, fullness(vertex));
    return worst;
  }

  // One round. An edge carries at most 1 / (2 degree) of what its donor has, so nothing becomes negative.
  void pull() {
    flows_.clear();
    for (const auto& [vertex, neighbours] : light_) {
      if (fullness(vertex) >= 1.0) continue;
      for (const VertexId donor : neighbours) {
        const double difference = fullness(donor) - fullness(vertex);
        if (difference <= 0.0) continue;
        const double floor = std::min(floor_[index(donor)], floor_[index(vertex)]);
        const auto degree = static_cast<double>(std::max(degree_of(donor), degree_of(vertex)));
        flows_.push_back({donor, vertex, difference * floor / (2.0 * degree)});
      }
    }
    for (const Flow& flow : flows_) {
      mass_[index(flow.from)] -= flow.mass;
      mass_[index(flow.to)] += flow.mass;
    }
    for (const Flow& flow : flows_) note(flow.from);
  }

 private:
  struct Flow {
    VertexId from;
    VertexId to;
    double mass;  // kg
  };

  static std::size_t index(VertexId vertex) { return static_cast<std::size_t>(vertex); }
  [[nodiscard]] double fullness(VertexId vertex) const { return mass_[index(vertex)] / floor_[index(vertex)]; }
  // At least the number of edges: a fan on the border has one more than triangles.
  [[nodiscard]] std::size_t degree_of(VertexId vertex) const { return incident_slots_.row(vertex).size() + 1; }
  void note(VertexId vertex) {
    if (mass_[index(vertex)] < floor_[index(vertex)] && light_.find(vertex) == light_.end()) {
      light_.emplace(vertex, neighbours_of(vertex, incident_slots_, blocks_));
    }
  }

  const RowStore<TriangleId>& incident_slots_;
  const std::span<const ElementBlock> blocks_;
  const std::span<const double> floor_;
  const std::span<double> mass_;
  std::map<VertexId, std::vector<VertexId>> light_;
  std::vector<Flow> flows_;
};

}  // namespace

double corner_stiffness(double gx, double gy, double area, const Eigen::Matrix3d& C) {
  return area *
         (C(0, 0) * gx * gx + C(1, 1) * gy * gy + C(2, 2) * (gx * gx + gy * gy) + 2.0 * (C(0, 2) + C(1, 2)) * gx * gy);
}

void redistribute_mass(const RowStore<TriangleId>& incident_slots, std::span<const ElementBlock> blocks,
                       std::span<const double> floor, std::span<double> mass) {
  LightVertices light(incident_slots, blocks, floor, mass);
  double worst = light.worst();
  for (int round = 0; round < kMaxRounds && worst < kReached; ++round) {
    light.pull();
    const double better = light.worst();
    if (better < worst * kLeastGain) return;
    worst = better;
  }
}

}  // namespace kerf::fem
