#pragma once

#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "server/core/sheet/moving_sheet.h"
#include "tests/support/scenes.h"

// Parts of a sheet for tests of one of them.
namespace kerf::sheet {

inline std::shared_ptr<const InitialState> initial_state_of(scene::SheetConfig config) {
  Result<InitialState> initial = make_initial_state(std::move(config));
  if (!initial.ok()) ADD_FAILURE() << initial.error().message;
  return std::make_shared<const InitialState>(std::move(initial).value());
}

inline MovingSheet moving_sheet_of(scene::SheetConfig config, IntegratorFactory make = fem::make_integrator) {
  return {initial_state_of(std::move(config)), std::move(make)};
}

inline std::uint64_t hash_of(const MovingSheet& sheet) {
  StateHash hash;
  sheet.add_to(hash);
  return hash.value();
}

}  // namespace kerf::sheet
