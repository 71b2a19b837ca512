#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/core/sheet/sheet.h"
#include "tests/bench/race_scene.h"

namespace kerf::bench {

struct SelfContactEntry {
  std::string setting;
  // Returns Bullet's soft body in the place of a sheet that stands above the floor z = 0.
  std::function<std::unique_ptr<Contender>(const sheet::Sheet& sheet)> enter;
};

// Settings of Bullet's self-collision; none where the program was built without Bullet.
std::vector<SelfContactEntry> bullet_self_contact_entries();

}  // namespace kerf::bench
