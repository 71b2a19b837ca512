// AnalyzeSheet: equilibria and vibrations of live sheets, on copies.
#include <cstring>
#include <future>

#include "tests/api/api_fixture.h"

namespace kerf::api {
namespace {

class AnalysisApiTest : public ApiTest {
 protected:
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

TEST_F(AnalysisApiTest, StopsWithWhatItHas) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  std::stop_source stop;
  stop.request_stop();
  const v1::AnalyzeSheetResponse found = analyze(resting("sheets/a"), stop.get_token()).value();
  EXPECT_FALSE(found.static_().converged());
  EXPECT_EQ(found.static_().load(), 0.0);
  EXPECT_EQ(found.tables(0).rows_size(), 0);
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
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::SetSheetPinsRequest free;
  free.set_name("sheets/a");
  free.mutable_set_pins();
  ASSERT_TRUE(call(&Api::set_sheet_pins, free).ok());
  // Nothing holds it: the search goes on until it is told to stop.
  v1::AnalyzeSheetRequest endless = resting("sheets/a");
  endless.mutable_analysis()->mutable_static_()->set_max_iterations(100'000);
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
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::SetSheetPinsRequest free;
  free.set_name("sheets/a");
  free.mutable_set_pins();
  ASSERT_TRUE(call(&Api::set_sheet_pins, free).ok());
  v1::AnalyzeSheetRequest endless = resting("sheets/a");
  endless.mutable_analysis()->mutable_static_()->set_max_iterations(100'000);
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
    return reply ? "done" : reply.error().reason + " " + reply.error().field;
  };
  EXPECT_EQ(refusal(resting("sheets/nobody")), "SHEET_NOT_FOUND name");
  v1::AnalyzeSheetRequest request = resting("sheets/a");
  request.mutable_analysis()->mutable_dynamic();
  EXPECT_EQ(refusal(request), "CHOICE_MISSING analysis.kind");
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
