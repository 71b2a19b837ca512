#include "tests/bench/race_bullet.h"

namespace kerf::bench {

std::vector<Entry> bullet_entries() {
  return {};
}

}  // namespace kerf::bench
