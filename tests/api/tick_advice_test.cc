#include "server/service/api/tick_advice.h"

#include <gtest/gtest.h>

#include "tests/api/cuts_fixture.h"

namespace kerf::api {
namespace {

TEST_F(ApiCutsTest, ASheetWhoseTicksDoNotFitSaysWhyAndWhatHelps) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::TickEstimate fits = get_sheet("sheets/a").tick_estimate();
  double sum = 0.0;
  for (const auto& [part, us] : fits.parts_us()) sum += us;
  EXPECT_NEAR(sum, fits.total_us(), 1e-9 * sum);
  EXPECT_EQ(fits.total_us(), fits.counted_us()) << "no tick was timed";
  EXPECT_EQ(fits.budget_us(), 20'000.0);
  EXPECT_EQ(fits.advice(), "");

  v1::CreateSheetRequest request;
  request.set_sheet_id("stiff");
  request.set_paused(true);
  v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
  grid.set_columns(40);
  grid.set_rows(40);
  grid.set_width_m(1.0);
  grid.set_height_m(1.0);
  request.mutable_scene()->mutable_material()->set_preset("wool");
  request.mutable_scene()->mutable_integrator()->set_kind(v1::Integrator::EXPLICIT_LEAPFROG);
  request.mutable_scene()->mutable_wind()->mutable_velocity_mps()->set_x(1.0);
  const v1::TickEstimate slow = call(&Api::create_sheet, request).value().tick_estimate();
  EXPECT_GT(slow.total_us(), slow.budget_us());
  EXPECT_NE(slow.advice().find("wind and other loads"), std::string::npos) << slow.advice();
  EXPECT_NE(slow.advice().find("Remedy: no wind"), std::string::npos) << slow.advice();
  EXPECT_NE(slow.advice().find("substeps"), std::string::npos) << slow.advice();
}

TEST_F(ApiCutsTest, ASheetWhoseSelfContactTakesMostOfATickSaysSo) {
  v1::CreateSheetRequest request;
  request.set_sheet_id("touching");
  request.set_paused(true);
  v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
  grid.set_columns(100);
  grid.set_rows(100);
  grid.set_width_m(1.0);
  grid.set_height_m(1.0);
  request.mutable_scene()->mutable_material()->set_preset("demo");
  request.mutable_scene()->mutable_self_contact()->set_mode(v1::SelfContact::ON);
  const v1::TickEstimate estimate = call(&Api::create_sheet, request).value().tick_estimate();
  EXPECT_GT(estimate.parts_us().at("self_contact"), 0.5 * estimate.total_us());
  EXPECT_NE(estimate.advice().find("of it is contact of the sheet with itself"), std::string::npos)
      << estimate.advice();
  EXPECT_NE(estimate.advice().find("no self-contact"), std::string::npos) << estimate.advice();
}

TEST_F(ApiCutsTest, ACutThatEndsRealTimeIsWarnedOf) {
  host::CommandTimings timings;
  timings.tick_before_us = 5'000.0;
  timings.tick_after_us = 40'000.0;
  timings.budget_us = 20'000.0;
  EXPECT_EQ(warning_of_slower_ticks(timings),
            "The sheet now falls behind: a tick takes 40 ms of the 20 ms available; before the cut it took 5 ms.");
  timings.tick_after_us = 20'000.0;
  EXPECT_EQ(warning_of_slower_ticks(timings), "");
  timings.tick_before_us = 30'000.0;
  timings.tick_after_us = 40'000.0;
  EXPECT_EQ(warning_of_slower_ticks(timings), "") << "it was behind before";
}

}  // namespace
}  // namespace kerf::api
