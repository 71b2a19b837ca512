#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/fem/stable_step.h"

namespace kerf::fem {
namespace {

TEST(RunningMaximum, IsTheMaximumWhileValuesChangeComeAndGo) {
  SeededRandom random(3);
  RunningMaximum running;
  std::vector<double> values;
  EXPECT_EQ(running.value(), 0.0);
  for (int step = 0; step < 2000; ++step) {
    if (step % 7 == 0) {
      values.resize(1 + random.below(step < 1000 ? 40 : 5000), 0.0);
      running.resize(values.size());
    }
    std::vector<std::int32_t> changed;
    for (std::uint64_t i = 0; i <= random.below(6); ++i) {
      const auto at = static_cast<std::int32_t>(random.below(values.size()));
      changed.push_back(at);
      values[static_cast<std::size_t>(at)] = random.uniform();
      running.set(static_cast<std::size_t>(at), values[static_cast<std::size_t>(at)]);
    }
    running.update(changed);
    ASSERT_EQ(running.value(), *std::max_element(values.begin(), values.end())) << "step " << step;
  }
}

}  // namespace
}  // namespace kerf::fem
