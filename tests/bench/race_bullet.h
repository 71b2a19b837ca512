#pragma once

#include <vector>

#include "tests/bench/race_scene.h"

namespace kerf::bench {

// Bullet's cloth with several settings; none where the program was built without Bullet.
std::vector<Entry> bullet_entries();

}  // namespace kerf::bench
