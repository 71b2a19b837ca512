#pragma once

#include <string>
#include <utility>

#include "tests/support/scenes.h"

// Scenes of several components, for tests.
namespace kerf::scenes {

inline scene::Component component(std::string name, scene::MeshSource mesh) {
  scene::Component made;
  made.name = std::move(name);
  made.mesh = std::move(mesh);
  return made;
}

inline scene::GridSource grid(std::int32_t columns, std::int32_t rows, double width, double height) {
  return {columns, rows, width, height, scene::GridPattern::kUniformDiagonals, 0};
}

// Returns a cloth of 1 m x 1 m with 11 x 11 vertices and a ribbon of 1 m x 0.2 m with 11 x 3. They hang beside each
// other, without pins.
inline scene::SheetConfig cloth_and_ribbon() {
  scene::SheetConfig config = hanging(3);
  config.pins.clear();
  config.components = {component("cloth", grid(11, 11, 1.0, 1.0)), component("ribbon", grid(11, 3, 1.0, 0.2))};
  return config;
}

// Returns the cut, of a component.
inline scene::Cut of(std::string name, scene::Cut cut) {
  cut.component = std::move(name);
  return cut;
}

}  // namespace kerf::scenes
