#pragma once

#include <vector>

#include "server/core/sheet/sheet.h"
#include "server/core/sheet/stage_observer.h"
#include "server/service/host/clock.h"

namespace kerf::host {

// Times the stages of one step() or apply(), per command.
class StageTimer : public sheet::StageObserver {
 public:
  struct CutTime {
    Nanoseconds cut{0};     // Planning and applying a cut, and remeshing.
    Nanoseconds update{0};  // Updating the mechanical model and the state.
  };

  explicit StageTimer(const Clock& clock) : clock_(clock) {}

  void begin(sheet::Stage /*stage*/, std::int32_t /*command*/) override { begun_ = clock_.now(); }
  void end(sheet::Stage stage, std::int32_t command) override {
    if (command < 0) return;
    const Nanoseconds took = clock_.now() - begun_;
    const auto index = static_cast<std::size_t>(command);
    if (index >= times_.size()) times_.resize(index + 1);
    CutTime& time = times_[index];
    if (stage == sheet::Stage::kCut) time.cut += took;
    if (stage == sheet::Stage::kModelUpdate) time.update += took;
  }

  // Returns the times of a command; zero if it had no such stage.
  [[nodiscard]] CutTime time(std::size_t command) const {
    return command < times_.size() ? times_[command] : CutTime{};
  }

 private:
  const Clock& clock_;
  std::vector<CutTime> times_;
  Nanoseconds begun_{0};
};

}  // namespace kerf::host
