#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/softening.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/snapshot.h"
#include "server/service/host/playback.h"

namespace kerf::host {

enum class RunState {
  kRunning,
  kPaused,
  kSleeping,  // At rest; uses no processor time until it is changed.
  kFailed,    // Frozen at its last good tick; still served, cuttable and resettable.
};

// Estimates the time of a tick from operation counts of the present sheet, scaled by the measured time of its ticks.
struct TickEstimate {
  fem::TickCost cost;   // Estimated from operation counts, for one core of 2024.
  double scale = 1.0;   // -, > 0: measured CPU time of this sheet's ticks over counted time; 1 before the first tick.
  double budget = 0.0;  // us, wall time between ticks at the present speed.

  [[nodiscard]] double total_us() const { return 1e-3 * scale * cost.total(); }
  [[nodiscard]] bool fits() const { return total_us() <= budget; }
};

// Describes a sheet between two ticks.
struct SheetStatus {
  std::string id;
  std::int64_t created_unix_us = 0;  // us since 1970; older than the server for a sheet of its store.
  // Tick from which on a recovered sheet differs from what it was.
  std::optional<std::int64_t> resimulated_from_tick;
  RunState run_state = RunState::kRunning;
  std::int64_t tick = 0;
  std::int32_t topology_version = 0;
  std::int32_t num_vertices = 0;
  std::int32_t num_triangles = 0;  // with material
  std::int32_t pieces = 0;
  std::optional<std::uint64_t> state_hash;  // Left out by statuses().
  std::int32_t viewers = 0;                 // Summed over all sinks.
  std::int64_t scene_tick = 0;              // see sheet::Sheet::scene_tick()
  sheet::RunStats stats;
  std::vector<mesh::VertexId> pinned_vertices;
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};            // m/s^2, in force
  scene::Wind wind;                                  // in force
  scene::SelfContact self_contact;                   // in force
  std::vector<fem::Material> materials;              // In force: the sheet's own, then those of config->materials.
  std::shared_ptr<const scene::SheetConfig> config;  // as created
  std::vector<scene::ComponentPlace> components;     // by index into config->components
  std::vector<std::string> mesh_notes;               // see sheet::Sheet::mesh_notes()
  std::string integrator;                            // Names the integrator in use and the reason for it.
  std::optional<fem::Softening> softening;           // In force with Fidelity::kRealTime.
  std::int32_t linear_iterations = 0;                // In the last tick, see fem::StepStats.
  double linear_residual = 0.0;                      // -, largest of the last tick, see fem::StepStats.
  fem::FlagCounts flagged_ticks{};                   // Since the sheet was made, resets included.
  std::optional<ReplayStatus> replay;                // Set for a sheet that plays, or played, a recording.
  TickEstimate tick_estimate;
  // Clusters of vertices that cuts made stiff, and the substeps that a tick needs with and without them; empty if there
  // are none.
  std::optional<fem::LocalInertiaStats> local_inertia;
};

// Holds the kept run of a sheet: config and entries are the whole content of a recording file.
struct KeptRun {
  std::shared_ptr<const scene::SheetConfig> config;
  std::string entries;  // Results of HostOptions::encode_tick, concatenated.
};

}  // namespace kerf::host
