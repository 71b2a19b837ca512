#include "client/load/plan.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace kerf::load {
namespace {

std::string refused(const std::function<void(Plan&)>& change) {
  Plan plan;
  change(plan);
  const Status status = check(plan);
  return status.ok() ? "" : status.error().message;
}

TEST(Plan, TheUsualOneIsRight) {
  EXPECT_TRUE(check(Plan()).ok());
}

TEST(Plan, RangesAreTakenToTheirEndsAndNotBeyond) {
  struct Case {
    const char* option;
    std::function<void(Plan&, double)> set;
    double least;
    double most;
  };
  const auto whole = [](double value) { return static_cast<std::int32_t>(value); };
  const Case cases[] = {
      {"--sheets", [&](Plan& p, double v) { p.sheets = whole(v); }, 1, 10'000},
      {"--tick-rate", [](Plan& p, double v) { p.tick_rate_hz = v; }, 1, 1000},
      {"--viewers", [&](Plan& p, double v) { p.viewers = whole(v); }, 0, 1000},
      {"--slow-readers", [&](Plan& p, double v) { p.slow_readers = whole(v); }, 0, 1000},
      {"--stalled-readers", [&](Plan& p, double v) { p.stalled_readers = whole(v); }, 0, 1000},
      {"--stall", [](Plan& p, double v) { p.stall_s = v; }, 0.001, 3600},
      {"--image-viewers", [&](Plan& p, double v) { p.image_viewers = whole(v); }, 0, 100},
      {"--cuts-per-second", [](Plan& p, double v) { p.cuts_per_second = v; }, 0, 1000},
      {"--way", [](Plan& p, double v) { p.way_ms = v; }, 0, 10'000},
      {"--duration", [](Plan& p, double v) { p.duration_s = v; }, 0.1, 1800},
      {"--warm-up", [](Plan& p, double v) { p.warm_up_s = v; }, 0, 600},
  };
  for (const Case& one : cases) {
    EXPECT_EQ(refused([&](Plan& p) { one.set(p, one.least); }), "") << one.option;
    EXPECT_EQ(refused([&](Plan& p) { one.set(p, one.most); }), "") << one.option;
    for (const double wrong : {one.least - 1.0, one.most + 1.0}) {
      const std::string message = refused([&](Plan& p) { one.set(p, wrong); });
      EXPECT_EQ(message.rfind(one.option, 0), 0U) << one.option << ": " << message;
      EXPECT_NE(message.find(".."), std::string::npos) << message;
    }
  }
  EXPECT_NE(refused([](Plan& p) { p.duration_s = std::numeric_limits<double>::quiet_NaN(); }), "");
  EXPECT_NE(refused([](Plan& p) { p.viewer_rate_hz = -1.0; }), "");
}

TEST(Plan, ASheetHasItsMostVertices) {
  EXPECT_EQ(refused([](Plan& p) { p.columns = 1000, p.rows = 500; }), "");
  EXPECT_NE(refused([](Plan& p) { p.columns = 1000, p.rows = 501; }).find("501000 vertices"), std::string::npos);
}

TEST(Plan, PrefixesAreTheBeginOfNames) {
  EXPECT_EQ(refused([](Plan& p) { p.prefix = "a-9"; }), "");
  for (const char* wrong : {"", "9a", "A", "a_b", "a/b", "-a"}) {
    EXPECT_NE(refused([&](Plan& p) { p.prefix = wrong; }).find("--prefix"), std::string::npos) << wrong;
  }
  EXPECT_NE(refused([](Plan& p) { p.prefix = std::string(42, 'a'); }), "");
}

TEST(Plan, WebSocketsNeedTheirPort) {
  EXPECT_NE(refused([](Plan& p) { p.transport = Transport::kWebSocket; }).find("--http"), std::string::npos);
}

}  // namespace
}  // namespace kerf::load
