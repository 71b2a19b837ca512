#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "server/core/sheet/sheet.h"
#include "server/core/sheet/stage_observer.h"
#include "tests/bench/cpu_time.h"

namespace kerf::bench {

// CPU time, s, of the stages of one step() or apply().
class StageClock : public sheet::StageObserver {
 public:
  void begin(sheet::Stage /*stage*/, std::int32_t /*command*/) override { started_ = entered_ = thread_cpu_s(); }
  void end(sheet::Stage stage, std::int32_t /*command*/) override {
    close_phase();
    spent_[static_cast<std::size_t>(stage)] += entered_ - started_;
    phase_ = nullptr;
  }
  void enter(const char* phase) override {
    close_phase();
    phase_ = phase;
  }
  [[nodiscard]] double spent(sheet::Stage stage) const { return spent_[static_cast<std::size_t>(stage)]; }
  [[nodiscard]] const std::vector<std::pair<const char*, double>>& phases() const { return phases_; }

 private:
  void close_phase() {
    const double now = thread_cpu_s();
    if (phase_ != nullptr) phases_.emplace_back(phase_, now - entered_);
    entered_ = now;
  }

  double started_ = 0.0;
  double entered_ = 0.0;
  const char* phase_ = nullptr;
  std::array<double, 4> spent_{};
  std::vector<std::pair<const char*, double>> phases_;  // in order
};

}  // namespace kerf::bench
