#include "server/service/host/entropy.h"

#include <set>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

TEST(Entropy, SeededRepeatsAndSystemDoesNot) {
  SeededEntropy a(4);
  SeededEntropy b(4);
  EXPECT_EQ(a.next(), b.next());
  EXPECT_EQ(a.next(), b.next());
  SystemEntropy system;
  std::set<std::uint64_t> seen;
  for (int i = 0; i < 100; ++i) seen.insert(system.next());
  EXPECT_EQ(seen.size(), 100U);
}

}  // namespace
}  // namespace kerf::host
