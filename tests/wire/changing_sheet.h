#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/base/random.h"
#include "server/core/sheet/snapshot.h"

namespace kerf::testing {

// Snapshots of a sheet that moves and is changed at random: no physics, no valid mesh, just arrays and versions that
// behave as a Topology's do.
class ChangingSheet {
 public:
  ChangingSheet(std::uint64_t seed, int num_vertices, int num_slots) : random_(seed) {
    topology_ = std::make_shared<sheet::Topology>();
    for (int v = 0; v < num_vertices; ++v) add_vertex(*topology_);
    for (int s = 0; s < num_slots; ++s) add_slot(*topology_);
    finish(*topology_);
  }

  // Every vertex moves by up to `distance` (m) an axis, the whole sheet by `drift` along x, and the tick is counted.
  void move(double distance, double drift = 0.0) {
    for (Eigen::Index i = 0; i < positions_.size(); ++i) {
      positions_.data()[i] += random_.uniform(-distance, distance) + (i % 3 == 0 ? drift : 0.0);
    }
    ++tick_;
  }

  // Simulates a cut: some slots rewritten, some added, some vertices added and moved in the material.
  void cut(int num_changes) {
    auto next = std::make_shared<sheet::Topology>(*topology_);
    ++next->version;
    for (int i = 0; i < num_changes; ++i) {
      add_vertex(*next);
      const auto vertex = random_.below(next->vertex_versions.size());
      next->material_positions.col(static_cast<Eigen::Index>(vertex)) = Eigen::Vector2d(random_.uniform(), 0.5);
      next->vertex_versions[vertex] = next->version;
      rewrite(*next, random_.below(next->triangles.size()));
      add_slot(*next);
    }
    finish(*next);
    topology_ = std::move(next);
  }

  // Fewer vertices and slots, as after a reset.
  void reset(int num_vertices, int num_slots) {
    auto next = std::make_shared<sheet::Topology>();
    next->version = topology_->version + 1;
    next->patchable_since = next->version;
    positions_.resize(3, 0);
    for (int v = 0; v < num_vertices; ++v) add_vertex(*next);
    for (int s = 0; s < num_slots; ++s) add_slot(*next);
    finish(*next);
    topology_ = std::move(next);
  }

  [[nodiscard]] std::shared_ptr<const sheet::Snapshot> snapshot(bool with_strains = false) const {
    auto snapshot = std::make_shared<sheet::Snapshot>();
    snapshot->tick = tick_;
    snapshot->positions = positions_;
    snapshot->topology = topology_;
    for (Eigen::Index v = 0; with_strains && v < positions_.cols(); ++v) {
      snapshot->strains.push_back(0.001F * static_cast<float>((7 * v + tick_) % 41) - 0.01F);
    }
    return snapshot;
  }

 private:
  void add_vertex(sheet::Topology& topology) {
    positions_.conservativeResize(3, positions_.cols() + 1);
    positions_.col(positions_.cols() - 1) = Eigen::Vector3d(random_.uniform(), random_.uniform(), 0.0);
    topology.material_positions.conservativeResize(2, positions_.cols());
    topology.material_positions.col(positions_.cols() - 1) = Eigen::Vector2d(random_.uniform(), random_.uniform());
    topology.vertex_versions.push_back(topology.version);
  }
  void add_slot(sheet::Topology& topology) {
    topology.triangles.push_back({});
    topology.pieces.push_back(0);
    topology.slot_versions.push_back(topology.version);
    rewrite(topology, topology.triangles.size() - 1);
  }
  void rewrite(sheet::Topology& topology, std::size_t slot) {
    const bool solid = random_.uniform() < 0.9;
    for (auto& vertex : topology.triangles[slot]) {
      vertex = solid ? static_cast<std::int32_t>(random_.below(topology.vertex_versions.size())) : mesh::kNone;
    }
    topology.pieces[slot] = solid ? static_cast<std::int32_t>(random_.below(3)) : mesh::kNone;
    topology.slot_versions[slot] = topology.version;
  }
  static void finish(sheet::Topology& topology) {
    topology.num_pieces = 3;
    topology.num_triangles = 0;
    for (const std::int32_t piece : topology.pieces) topology.num_triangles += piece == mesh::kNone ? 0 : 1;
  }

  SeededRandom random_;
  std::int64_t tick_ = 0;
  Eigen::Matrix3Xd positions_{3, 0};
  std::shared_ptr<sheet::Topology> topology_;
};

}  // namespace kerf::testing
