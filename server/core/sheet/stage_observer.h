#pragma once

#include <cstdint>

#include "server/base/phase_observer.h"

namespace kerf::sheet {

// The parts of a tick, in the order in which they run.
enum class Stage {
  kCut,          // plan, apply, local remesh of one cut
  kModelUpdate,  // model, state, pins and grabs of the slots a cut touched
  kLoads,        // gravity, wind, pins and grabs handed to the integrator
  kIntegrate,    // the integrator's substeps, contact among them
};

// Receives the beginning and the end of each stage, so that the owner can time them: the sheet itself reads no clock.
class StageObserver : public PhaseObserver {
 public:
  // `command`: which of the commands of this step() or apply(), in the order in which they are done: scheduled ones
  // first, then those given, then what falls due as one of these was a Reset; -1 where the stage serves none of them
  // (loads, integration).
  virtual void begin(Stage stage, std::int32_t command) = 0;
  virtual void end(Stage stage, std::int32_t command) = 0;
  // The parts of kCut and kModelUpdate, as they begin.
  void enter(const char* /*phase*/) override {}
};

}  // namespace kerf::sheet
