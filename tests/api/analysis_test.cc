// AnalyzeSheet: equilibria, vibrations and ticks to come of live sheets, on copies.
#include <cmath>
#include <future>

#include "tests/api/fixture.h"
#include "tests/support/failing_integrator.h"

namespace kerf::api {
namespace {

class AnalysisApiTest : public ApiTest {
 protected:
  using ApiTest::ApiTest;

  // The answer comes from a thread of its own.
  Result<v1::AnalyzeSheetResponse> analyze(const v1::AnalyzeSheetRequest& request, std::stop_token stop = {}) {
    auto promise = std::make_shared<std::promise<Result<v1::AnalyzeSheetResponse>>>();
    api_->analyze_sheet(
        request, [promise](Result<v1::AnalyzeSheetResponse> reply) { promise->set_value(std::move(reply)); },
        std::move(stop));
    return promise->get_future().get();
  }

  static v1::AnalyzeSheetRequest resting(const std::string& name) {
    v1::AnalyzeSheetRequest request;
    request.set_name(name);
    request.mutable_analysis()->mutable_static_();
    v1::Probe& probe = *request.add_probes();
    probe.set_name("top");
    probe.set_quantity(v1::Probe::REACTION);
    probe.mutable_region()->set_edge(v1::Region::TOP);
    return request;
  }

  // Requests an endless analysis of a falling sheet. Its pressure turns with it, so only the search itself, which runs
  // until it is stopped, can find that there is no equilibrium.
  v1::AnalyzeSheetRequest create_endless(const std::string& id) {
    v1::CreateSheetRequest request;
    request.set_sheet_id(id);
    request.set_paused(true);
    v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
    grid.set_columns(7);
    grid.set_rows(7);
    grid.set_width_m(1.0);
    grid.set_height_m(1.0);
    v1::Pressure& pressure = *request.mutable_scene()->add_loads()->mutable_pressure();
    pressure.mutable_region()->set_all(true);
    pressure.set_pressure_pa(1.0e-6);
    EXPECT_TRUE(call(&Api::create_sheet, request).ok());
    v1::AnalyzeSheetRequest endless = resting("sheets/" + id);
    endless.mutable_analysis()->mutable_static_()->set_max_iterations(100'000);
    return endless;
  }
};

TEST_F(AnalysisApiTest, FindsTheEquilibriumOfACopy) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/a","ticks":5})").ok());
  const v1::Sheet before = get_sheet("sheets/a");
  v1::AnalyzeSheetRequest request = resting("sheets/a");
  request.set_positions(true);
  const v1::AnalyzeSheetResponse found = analyze(request).value();
  EXPECT_EQ(found.name(), "sheets/a");
  EXPECT_EQ(found.tick(), before.tick());
  EXPECT_EQ(found.topology_version(), before.topology_version());
  EXPECT_TRUE(found.static_().converged());
  EXPECT_LE(found.static_().residual(), 1e-9);
  ASSERT_EQ(found.tables_size(), 1);
  EXPECT_EQ(found.tables(0).columns(3), "top.z");
  EXPECT_GT(found.tables(0).rows(0).values(3), 0.0) << "it hangs";
  EXPECT_EQ(found.positions().size(), 24U * static_cast<std::size_t>(before.num_vertices()));
  EXPECT_EQ(get_sheet("sheets/a").state_hash(), before.state_hash());
}

TEST_F(AnalysisApiTest, FindsVibrations) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::AnalyzeSheetRequest request;
  request.set_name("sheets/a");
  request.mutable_analysis()->mutable_modes()->set_count(4);
  const v1::AnalyzeSheetResponse found = analyze(request).value();
  EXPECT_FALSE(found.has_static_());
  ASSERT_EQ(found.tables_size(), 1);
  EXPECT_EQ(found.tables(0).name(), "modes");
  EXPECT_EQ(found.tables(0).rows_size(), 4);
}

v1::Probe& add_probe(v1::AnalyzeSheetRequest& request, const std::string& name, v1::Probe::Quantity quantity) {
  v1::Probe& probe = *request.add_probes();
  probe.set_name(name);
  probe.set_quantity(quantity);
  return probe;
}

// Every kind of probe, at a point of a slit that reaches in from the left.
v1::AnalyzeSheetRequest ticks_of(const std::string& name, std::int64_t ticks) {
  v1::AnalyzeSheetRequest request;
  request.set_name(name);
  request.mutable_analysis()->mutable_dynamic()->set_ticks(ticks);
  for (int q = v1::Probe::DISPLACEMENT; q <= v1::Probe::INTERSECTIONS; ++q) {
    const auto quantity = static_cast<v1::Probe::Quantity>(q);
    v1::Probe& probe = add_probe(request, "p" + std::to_string(q), quantity);
    const bool is_global = q >= v1::Probe::ENERGY && q != v1::Probe::OPENING;
    if (quantity == v1::Probe::REACTION) {
      probe.mutable_region()->set_edge(v1::Region::TOP);
    } else if (!is_global) {
      probe.add_points()->set_x(0.2);
      probe.mutable_points(0)->set_y(0.45);
    }
  }
  return request;
}

class DynamicAnalysisApiTest : public AnalysisApiTest {
 protected:
  using AnalysisApiTest::AnalysisApiTest;

  // Slit and swinging, grabbed, in the wind.
  void make_busy_sheet() {
    ASSERT_TRUE(create_sheet("a", true).ok());
    v1::CreateCutRequest slit = cut_request("sheets/a", 0.45);
    slit.mutable_cut()->mutable_curve()->mutable_polyline()->mutable_points(1)->set_x(0.5);
    ASSERT_TRUE(call(&Api::create_cut, slit).ok());
    ASSERT_TRUE(call_json("/kerf.v1.InteractionService/SetSheetWind",
                          R"({"name":"sheets/a","set_wind":{"wind":{"velocity_mps":{"y":3}}}})")
                    .ok());
    step(5);
  }
  void step(int ticks) {
    ASSERT_TRUE(
        call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/a","ticks":)" + std::to_string(ticks) + "}")
            .ok());
  }
};

TEST_F(DynamicAnalysisApiTest, GoesOnAsTheSheetItselfWillWhichIsLeftAsItIs) {
  make_busy_sheet();
  const v1::Sheet before = get_sheet("sheets/a");
  v1::AnalyzeSheetRequest request = ticks_of("sheets/a", 12);
  request.set_positions(true);
  const v1::AnalyzeSheetResponse found = analyze(request).value();
  EXPECT_EQ(get_sheet("sheets/a").state_hash(), before.state_hash());
  EXPECT_EQ(get_sheet("sheets/a").tick(), before.tick());
  EXPECT_EQ(found.tick(), before.tick());
  EXPECT_EQ(found.dynamic().ticks(), 12);
  EXPECT_NEAR(found.dynamic().simulated_s(), 12 / 50.0, 1e-12);
  EXPECT_NE(found.dynamic().state_hash(), before.state_hash());
  const v1::Table& table = found.tables(0);
  ASSERT_EQ(table.rows_size(), 13);
  EXPECT_EQ(table.columns(0), "time_s");
  for (const v1::Table::Row& row : table.rows()) {
    for (const double value : row.values()) EXPECT_TRUE(std::isfinite(value));
  }
  step(12);
  const v1::Sheet after = get_sheet("sheets/a");
  EXPECT_EQ(found.dynamic().state_hash(), after.state_hash()) << "it came as was foretold";
  v1::GetSheetStateRequest exact;
  exact.set_name("sheets/a");
  EXPECT_EQ(found.positions(), call(&Api::get_sheet_state, exact).value().positions());
  // Equals the last row of the forecast, except for the forces of the held vertices' motion.
  const v1::AnalyzeSheetResponse now = analyze(ticks_of("sheets/a", 0)).value();
  EXPECT_EQ(now.dynamic().ticks(), 0);
  EXPECT_EQ(now.dynamic().state_hash(), after.state_hash());
  ASSERT_EQ(now.tables(0).rows_size(), 1);
  EXPECT_EQ(now.tables(0).rows(0).values(0), 0.0);
  for (int i = 1; i < table.columns_size(); ++i) {
    if (table.columns(i).starts_with("p4.")) continue;
    EXPECT_EQ(now.tables(0).rows(0).values(i), table.rows(12).values(i)) << table.columns(i);
  }
}

TEST_F(DynamicAnalysisApiTest, AnswersOverJsonToo) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::AnalyzeSheetResponse found = analyze(ticks_of("sheets/a", 3)).value();
  EXPECT_EQ(found.dynamic().ticks(), 3);
  auto promise = std::make_shared<std::promise<Result<std::string>>>();
  for (const Method& method : api_->methods()) {
    if (method.path != "/kerf.v1.SheetService/AnalyzeSheet") continue;
    method.call(R"({"name":"sheets/a","analysis":{"dynamic":{"ticks":"3"}}})", Encoding::kJson, caller_,
                [promise](Result<std::string> reply) { promise->set_value(std::move(reply)); }, {});
  }
  const std::string json = promise->get_future().get().value();
  EXPECT_NE(json.find(found.dynamic().state_hash()), std::string::npos) << json;
  EXPECT_EQ(json.find("\"probes\""), std::string::npos) << "the scene has none: no table";
}

TEST_F(DynamicAnalysisApiTest, StopsWithTheTicksItHas) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  std::stop_source stop;
  stop.request_stop();
  v1::AnalyzeSheetRequest request;
  request.set_name("sheets/a");
  request.mutable_analysis()->mutable_dynamic()->set_ticks(100'000);
  const v1::AnalyzeSheetResponse found = analyze(request, stop.get_token()).value();
  EXPECT_EQ(found.dynamic().ticks(), 0);
}

TEST_F(DynamicAnalysisApiTest, LimitsTheNumbersThatItMeasures) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::AnalyzeSheetRequest request;
  request.set_name("sheets/a");
  v1::Probe& probe = add_probe(request, "p", v1::Probe::POSITION);
  for (int i = 0; i < 1024; ++i) probe.add_points();
  // 3,073 columns: 650 rows are 1,997,450 numbers, 651 are 2,000,523.
  request.mutable_analysis()->mutable_dynamic()->set_ticks(649);
  const Result<v1::AnalyzeSheetResponse> refused = analyze(request);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "TABLE_TOO_LARGE");
  EXPECT_EQ(refused.error().field, "analysis.dynamic.measure_every");
  std::stop_source stop;
  stop.request_stop();
  request.mutable_analysis()->mutable_dynamic()->set_ticks(648);
  EXPECT_TRUE(analyze(request, stop.get_token()).ok());
  request.mutable_analysis()->mutable_dynamic()->set_ticks(100'000);
  request.mutable_analysis()->mutable_dynamic()->set_measure_every(1000);
  EXPECT_TRUE(analyze(request, stop.get_token()).ok());
}

class FailingAnalysisApiTest : public DynamicAnalysisApiTest {
 protected:
  static host::HostOptions failing() {
    host::HostOptions options = small_host();
    options.make_integrator = scenes::make_failing_integrator;
    return options;
  }
  FailingAnalysisApiTest() : DynamicAnalysisApiTest(failing()) {}

  void fail() {
    ASSERT_TRUE(call_json("/kerf.v1.InteractionService/SetSheetGravity",
                          R"({"name":"sheets/a","set_gravity":{"gravity_mps2":{"z":66}}})")
                    .ok());
  }
};

TEST_F(FailingAnalysisApiTest, TellsFlagsAndMeasuresAFrozenSheetOnlyAsItIs) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  fail();
  const v1::AnalyzeSheetResponse found = analyze(ticks_of("sheets/a", 10)).value();
  EXPECT_EQ(found.dynamic().ticks(), 3) << "the copy froze";
  EXPECT_EQ(found.dynamic().flagged_ticks().at("frozen"), 3);
  EXPECT_EQ(found.dynamic().flagged_ticks().size(), 1U);
  EXPECT_TRUE(get_sheet("sheets/a").flagged_ticks().empty()) << "the sheet did not";
  EXPECT_FALSE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/a","ticks":10})").ok());
  EXPECT_EQ(get_sheet("sheets/a").flagged_ticks().at("frozen"), 3);
  const Result<std::string> json = call_json("/kerf.v1.SheetService/GetSheet", R"({"name":"sheets/a"})");
  EXPECT_NE(json->find(R"("flagged_ticks":{"frozen":"3"})"), std::string::npos) << *json;
  v1::ListSheetsRequest all;
  EXPECT_EQ(call(&Api::list_sheets, all)->sheets(0).flagged_ticks().at("frozen"), 3);
  const Result<v1::AnalyzeSheetResponse> refused = analyze(ticks_of("sheets/a", 1));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kFailedPrecondition);
  EXPECT_EQ(refused.error().reason, "SHEET_FROZEN");
  EXPECT_TRUE(analyze(ticks_of("sheets/a", 0)).ok());
}

TEST_F(AnalysisApiTest, StopsWithWhatItHas) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  std::stop_source stop;
  stop.request_stop();
  const v1::AnalyzeSheetResponse found = analyze(resting("sheets/a"), stop.get_token()).value();
  EXPECT_FALSE(found.static_().converged());
  EXPECT_EQ(found.static_().load(), 0.0);
  EXPECT_EQ(found.tables(0).rows_size(), 0);
}

TEST_F(AnalysisApiTest, SaysThatNothingHoldsASheet) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::SetSheetPinsRequest free;
  free.set_name("sheets/a");
  free.mutable_set_pins();
  ASSERT_TRUE(call(&Api::set_sheet_pins, free).ok());
  v1::SetSheetWindRequest wind;
  wind.set_name("sheets/a");
  wind.mutable_set_wind()->mutable_wind()->mutable_velocity_mps()->set_x(2.0);
  ASSERT_TRUE(call(&Api::set_sheet_wind, wind).ok());
  const v1::AnalyzeSheetResponse found = analyze(resting("sheets/a")).value();
  EXPECT_FALSE(found.static_().converged());
  EXPECT_EQ(found.static_().newton_iterations(), 0);
  EXPECT_NE(found.static_().reason().find("nothing holds the sheet"), std::string::npos);
  ASSERT_EQ(found.static_().left_out_size(), 1);
  EXPECT_EQ(found.static_().left_out(0), "wind");
}

TEST_F(AnalysisApiTest, RefusesSheetsThatAreTooLarge) {
  Limits limits;
  limits.max_analyzed_vertices = 49;
  make_api(limits, nullptr);
  ASSERT_TRUE(create_sheet("a", true).ok());
  EXPECT_TRUE(analyze(resting("sheets/a")).ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  const Result<v1::AnalyzeSheetResponse> refused = analyze(resting("sheets/a"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "SHEET_TOO_LARGE");
}

TEST_F(AnalysisApiTest, RefusesMoreThanMayWait) {
  Limits limits;
  limits.max_waiting_analyses = 0;
  make_api(limits, nullptr);
  const v1::AnalyzeSheetRequest endless = create_endless("a");
  std::stop_source stop;
  auto promise = std::make_shared<std::promise<Result<v1::AnalyzeSheetResponse>>>();
  api_->analyze_sheet(
      endless, [promise](Result<v1::AnalyzeSheetResponse> reply) { promise->set_value(std::move(reply)); },
      stop.get_token());
  host_->wait_idle();
  const Result<v1::AnalyzeSheetResponse> second = analyze(resting("sheets/a"));
  stop.request_stop();
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().reason, "TOO_MANY_ANALYSES");
  const Result<v1::AnalyzeSheetResponse> first = promise->get_future().get();
  ASSERT_TRUE(first.ok());
  EXPECT_FALSE(first->static_().converged());
}

TEST_F(AnalysisApiTest, EndsWhenTheServerStops) {
  const v1::AnalyzeSheetRequest endless = create_endless("a");
  auto promise = std::make_shared<std::promise<Result<v1::AnalyzeSheetResponse>>>();
  api_->analyze_sheet(endless,
                      [promise](Result<v1::AnalyzeSheetResponse> reply) { promise->set_value(std::move(reply)); }, {});
  host_->wait_idle();
  api_->stop();
  EXPECT_EQ(promise->get_future().get().error().code, ErrorCode::kUnavailable);
}

TEST_F(AnalysisApiTest, NamesWhatIsWrong) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const auto refusal = [&](const v1::AnalyzeSheetRequest& request) {
    const Result<v1::AnalyzeSheetResponse> reply = analyze(request);
    return reply.ok() ? "done" : reply.error().reason + " " + reply.error().field;
  };
  EXPECT_EQ(refusal(resting("sheets/nobody")), "SHEET_NOT_FOUND name");
  v1::AnalyzeSheetRequest request = resting("sheets/a");
  request.clear_analysis();
  EXPECT_EQ(refusal(request), "CHOICE_MISSING analysis.kind");
  for (const std::int64_t ticks : {-1, 100'001}) {
    request.mutable_analysis()->mutable_dynamic()->set_ticks(ticks);
    EXPECT_EQ(refusal(request), "OUT_OF_RANGE analysis.dynamic.ticks");
  }
  request.mutable_analysis()->mutable_dynamic()->set_ticks(1);
  request.mutable_analysis()->mutable_dynamic()->set_measure_every(-1);
  EXPECT_EQ(refusal(request), "OUT_OF_RANGE analysis.dynamic.measure_every");
  request = resting("sheets/a");
  request.mutable_analysis()->mutable_static_()->set_tolerance(0.2);
  EXPECT_EQ(refusal(request), "OUT_OF_RANGE analysis.static.tolerance");
  request = resting("sheets/a");
  request.mutable_probes(0)->set_quantity(v1::Probe::STRESS);
  EXPECT_EQ(refusal(request), "REGION_EMPTY probes[0].region");
  request = resting("sheets/a");
  request.mutable_probes(0)->clear_name();
  EXPECT_EQ(refusal(request), "PROBE_NAME probes[0].name");
  request.clear_probes();
  request.mutable_analysis()->mutable_modes()->set_count(126);
  EXPECT_EQ(refusal(request), "TOO_MANY_MODES analysis.modes.count");
}

}  // namespace
}  // namespace kerf::api
