#pragma once

#include <vector>

#include "server/host/clock.h"
#include "server/sheet/sheet.h"

namespace kerf::host {

// Times the stages of one step() or apply(), by command.
class StageTimer : public sheet::StageObserver {
 public:
  struct CutTime {
    Nanoseconds cut{0};     // plan, apply, remesh
    Nanoseconds update{0};  // model and state
  };

  // For `num_commands` commands from outside.
  StageTimer(const Clock& clock, std::size_t num_commands) : clock_(clock), times_(num_commands) {}

  void begin(sheet::Stage /*stage*/, std::int32_t /*command*/) override { begun_ = clock_.now(); }
  void end(sheet::Stage stage, std::int32_t command) override {
    if (command < 0) return;
    const Nanoseconds took = clock_.now() - begun_;
    CutTime& time = times_[static_cast<std::size_t>(command)];
    if (stage == sheet::Stage::kCut) time.cut += took;
    if (stage == sheet::Stage::kModelUpdate) time.update += took;
  }

  [[nodiscard]] const CutTime& time(std::size_t command) const { return times_[command]; }

 private:
  const Clock& clock_;
  std::vector<CutTime> times_;
  Nanoseconds begun_{0};
};

}  // namespace kerf::host
