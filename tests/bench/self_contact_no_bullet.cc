#include "tests/bench/self_contact_bullet.h"

namespace kerf::bench {

std::vector<SelfContactEntry> bullet_self_contact_entries() {
  return {};
}

}  // namespace kerf::bench
