#include "client/cli/progress.h"

#include <gtest/gtest.h>

namespace kerf::cli {
namespace {

TEST(Progress, ALineHasTheShareTheTimeLeftAndWhatIsDone) {
  EXPECT_EQ(progress_line(0.0, 0.0, "tick 0"), "[..............................]   0 %  tick 0");
  EXPECT_EQ(progress_line(0.5, 10.0, "tick 5"), "[###############...............]  50 %  0:10 left  tick 5");
  EXPECT_EQ(progress_line(0.25, 30.0, ""), "[#######.......................]  25 %  1:30 left  ");
  EXPECT_EQ(progress_line(0.5, 7325.0, ""), "[###############...............]  50 %  2:02:05 left  ");
  EXPECT_EQ(progress_line(1.0, 4.0, ""), "[##############################] 100 %  0:00 left  ");
}

TEST(Progress, NoTimeIsToldBeforeThereIsOneToTell) {
  EXPECT_EQ(progress_line(0.5, 0.5, "").find("left"), std::string::npos);
  EXPECT_EQ(progress_line(0.005, 60.0, "").find("left"), std::string::npos);
}

TEST(Progress, SharesOutOfRangeStayInTheBar) {
  EXPECT_EQ(progress_line(1.5, 0.0, ""), progress_line(1.0, 0.0, ""));
  EXPECT_EQ(progress_line(-1.0, 0.0, ""), progress_line(0.0, 0.0, ""));
}

}  // namespace
}  // namespace kerf::cli
