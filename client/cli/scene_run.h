#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "kerf/v1/run.pb.h"
#include "server/base/result.h"
#include "server/core/analysis/analysis.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::cli {

struct SceneRun {
  v1::RunResult result;
  std::string recording;  // the file's bytes; empty unless asked for
};

struct SceneRunOptions {
  std::int64_t ticks = 0;  // 0: the scene's own
  bool record = false;
  std::string build;      // written into the recording
  analysis::Watch watch;  // told of the progress; may be empty
};

// Does what the scene's analysis says, from its start, as fast as this machine can, with no clock and no server. Equal
// scenes give equal state hashes. Errors: those of Sheet::create and of the analysis; a recording can be made of a
// dynamic one only (RECORDING_DYNAMIC_ONLY).
Result<SceneRun> run_scene(const sheet::SheetConfig& config, const SceneRunOptions& options);

}  // namespace kerf::cli
