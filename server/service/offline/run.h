#pragma once

#include <cstdint>
#include <string>

#include "kerf/v1/run.pb.h"
#include "server/base/result.h"
#include "server/core/analysis/analysis.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::offline {

struct SceneRun {
  v1::RunResult result;
  std::string recording;  // The file's bytes; empty unless requested.
};

struct SceneRunOptions {
  std::int64_t ticks = 0;  // Ticks to step; 0: those of the scene, or 600 if it gives none.
  bool record = false;
  analysis::Watch watch = {};  // Receives the progress; may be empty. Returns false to end the run early.
};

// Runs the scene's analysis from its start, as fast as this machine can, without clock or server. Equal scenes give
// equal state hashes. Errors: those of Sheet::create and of the analysis. Only a dynamic analysis can be recorded
// (RECORDING_DYNAMIC_ONLY).
Result<SceneRun> run_scene(const scene::SheetConfig& config, const SceneRunOptions& options);

}  // namespace kerf::offline
