#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "server/core/scene/sheet_config.h"

// Sheets that pass through themselves from the start, in free space without gravity, with self-contact. The material is
// that of tests/support/self_contact_scenes.h. `side`: vertices along 0.3 m, 8..100.
namespace kerf::scenes {

// A horizontal square, and a strip of a third of its width that stands on it. The strip has been pushed through by
// `depth`, 0..0.3 m, so that its lower end is below. It stands in the middle, or half beyond the border.
scene::SheetConfig pushed_through(double depth, bool is_at_border = false, std::int32_t side = 16);

// Returns the material place (m) of the square below the strip in the middle, for 16 vertices a side. `place`: 0 at one
// side of the strip, 1 at the other.
Eigen::Vector2d at_strip(double place);

// Two squares 1 mm apart, with a bump of the lower one, 3 edges wide, that reaches `depth` (0..0.1 m) beyond the upper
// one.
scene::SheetConfig poked_through(double depth, std::int32_t side = 16);

}  // namespace kerf::scenes
