#pragma once

#include <cstdint>

#include "server/base/phase_observer.h"

namespace kerf::sheet {

// The parts of a tick, in the order in which they run.
enum class Stage {
  kCut,          // planning and applying one cut, with local remeshing
  kModelUpdate,  // update of model, state, pins and grabs where a cut changed the mesh
  kLoads,        // setting gravity, wind, pins and grabs for the integrator
  kIntegrate,    // the integrator's substeps, including contact
};

// Receives the beginning and end of each stage, so that the owner can time them. The sheet itself reads no clock.
class StageObserver : public PhaseObserver {
 public:
  // `command`: number of the command, in the order in which this step() or apply() does them, from 0. Scheduled
  // commands come first, then the given ones, then those that are due because one of these was a Reset. -1: the stage
  // belongs to no command (loads, integration).
  virtual void begin(Stage stage, std::int32_t command) = 0;
  virtual void end(Stage stage, std::int32_t command) = 0;
  // Called when a part of kCut or kModelUpdate begins.
  void enter(const char* /*phase*/) override {}
};

}  // namespace kerf::sheet
