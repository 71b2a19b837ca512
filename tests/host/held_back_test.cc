#include "server/service/host/held_back.h"

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

TEST(HeldBack, ReleasesTheNewestValueThatShowsOnlyDurableChanges) {
  HeldBack<int> held;
  EXPECT_EQ(held.take(9), std::nullopt);
  held.add(3, 30);
  held.add(3, 31);
  EXPECT_EQ(held.take(2), std::nullopt);
  EXPECT_EQ(held.take(3), 31);
  EXPECT_EQ(held.take(3), std::nullopt);
}

TEST(HeldBack, KeepsTheOldestAndTheNewestOfManyValues) {
  HeldBack<int> held;
  for (int i = 1; i <= 5; ++i) held.add(i, 10 * i);
  EXPECT_EQ(held.take(4), 10) << "one comes out though there is always a newer change";
  held.add(6, 60);
  EXPECT_EQ(held.take(5), 50);
  EXPECT_EQ(held.take(6), 60);
}

TEST(HeldBack, ForgetsOlderValuesThatCouldBeReleasedWithTheNewest) {
  HeldBack<int> held;
  held.add(1, 10);
  held.add(2, 20);
  EXPECT_EQ(held.take(2), 20);
  held.add(3, 30);
  held.clear();
  EXPECT_EQ(held.take(3), std::nullopt);
}

}  // namespace
}  // namespace kerf::host
