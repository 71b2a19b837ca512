// StepSheets: steps several sheets and answers with their states and the values of probes.
#include <cmath>
#include <cstring>

#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

class StepSheetsTest : public ApiTest {
 protected:
  void SetUp() override {
    for (const char* id : {"a", "b", "c"}) ASSERT_TRUE(create_sheet(id, true).ok());
  }
  static v1::StepSheetsRequest request_of(const std::vector<std::string>& ids, int ticks) {
    v1::StepSheetsRequest request;
    for (const std::string& id : ids) request.add_names("sheets/" + id);
    request.set_ticks(ticks);
    return request;
  }
  Result<v1::StepSheetsResponse> step(const v1::StepSheetsRequest& request) { return call(&Api::step_sheets, request); }
  std::string refusal(const v1::StepSheetsRequest& request) {
    const Result<v1::StepSheetsResponse> reply = step(request);
    return reply.ok() ? "" : reply.error().reason + " " + reply.error().field;
  }
  v1::SheetState state(const std::string& name) {
    v1::GetSheetStateRequest request;
    request.set_name(name);
    return call(&Api::get_sheet_state, request).value();
  }
};

TEST_F(StepSheetsTest, AnswersAsStepSheetAndGetSheetStateDo) {
  v1::StepSheetsRequest request = request_of({"b", "a"}, 6);
  request.set_states(true);
  const v1::StepSheetsResponse reply = step(request).value();
  ASSERT_EQ(reply.sheets_size(), 2);
  for (const v1::SteppedSheet& stepped : reply.sheets()) {
    EXPECT_EQ(stepped.tick(), 6);
    EXPECT_EQ(stepped.state().SerializeAsString(), state(stepped.name()).SerializeAsString());
    EXPECT_EQ(stepped.failure(), "");
  }
  EXPECT_EQ(reply.sheets(0).name(), "sheets/b");
  EXPECT_EQ(get_sheet("sheets/c").tick(), 0);
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/c","ticks":6})").ok());
  EXPECT_EQ(get_sheet("sheets/c").state_hash(), reply.sheets(1).state().state_hash()) << "the same ticks";
  EXPECT_FALSE(step(request_of({"a"}, 1)).value().sheets(0).has_state());
}

TEST_F(StepSheetsTest, LeavesOutATopologyThatTheCallerHas) {
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/b", 0.45)).ok());
  v1::StepSheetsRequest request = request_of({"a", "b"}, 1);
  request.set_states(true);
  request.add_topology_versions(1);
  request.add_topology_versions(1);
  const v1::StepSheetsResponse reply = step(request).value();
  EXPECT_TRUE(reply.sheets(0).state().triangles().empty());
  EXPECT_TRUE(reply.sheets(0).state().material_positions().empty());
  EXPECT_EQ(reply.sheets(0).state().positions(), state("sheets/a").positions());
  EXPECT_EQ(reply.sheets(1).topology_version(), 2);
  EXPECT_EQ(reply.sheets(1).state().triangles(), state("sheets/b").triangles());
  request.add_topology_versions(1);
  EXPECT_EQ(refusal(request), "OUT_OF_RANGE topology_versions");
}

TEST_F(StepSheetsTest, MeasuresProbesAfterTheLastTick) {
  v1::StepSheetsRequest request = request_of({"a", "b"}, 4);
  request.set_states(true);
  v1::Probe& probe = *request.add_probes();
  probe.set_name("corner");
  probe.set_quantity(v1::Probe::POSITION);
  probe.add_points();
  const v1::StepSheetsResponse reply = step(request).value();
  ASSERT_EQ(reply.probe_columns_size(), 3);
  EXPECT_EQ(reply.probe_columns(2), "corner.z");
  for (const v1::SteppedSheet& stepped : reply.sheets()) {
    ASSERT_EQ(stepped.probe_values_size(), 3);
    double z = 0.0;
    std::memcpy(&z, stepped.state().positions().data() + 16, 8);
    EXPECT_EQ(stepped.probe_values(2), z);
  }
}

TEST_F(StepSheetsTest, PlacesThatACutRemovedHaveNoValues) {
  v1::CreateCutRequest strip = cut_request("sheets/a", 0.45);
  strip.mutable_cut()->set_width_m(0.2);
  ASSERT_TRUE(call(&Api::create_cut, strip).ok());
  v1::StepSheetsRequest request = request_of({"a"}, 1);
  v1::Probe& point = *request.add_probes();
  point.set_name("gone");
  point.set_quantity(v1::Probe::POSITION);
  point.add_points()->set_x(0.5);
  point.mutable_points(0)->set_y(0.45);
  v1::Probe& region = *request.add_probes();
  region.set_name("unknown");
  region.set_quantity(v1::Probe::POSITION);
  region.mutable_region()->mutable_vertices()->add_vertices(100'000);
  const v1::StepSheetsResponse reply = step(request).value();
  for (const double value : reply.sheets(0).probe_values()) EXPECT_TRUE(std::isnan(value));
  EXPECT_EQ(reply.sheets(0).probe_values_size(), 6);
}

TEST_F(StepSheetsTest, RefusesBeforeAnySheetIsStepped) {
  EXPECT_EQ(refusal(request_of({}, 1)), "OUT_OF_RANGE names");
  EXPECT_EQ(refusal(request_of(std::vector<std::string>(257, "a"), 1)), "OUT_OF_RANGE names");
  EXPECT_EQ(refusal(request_of({"a", "b", "a"}, 1)), "NAMED_TWICE names[2]");
  EXPECT_EQ(refusal(request_of({"a", "B"}, 1)), "NAME_MALFORMED names[1]");
  EXPECT_EQ(refusal(request_of({"a", "gone"}, 1)), "SHEET_NOT_FOUND names[1]");
  EXPECT_EQ(refusal(request_of({"a", "b"}, 0)), "OUT_OF_RANGE ticks");
  EXPECT_EQ(refusal(request_of({"a", "b"}, 100'001)), "OUT_OF_RANGE ticks");
  v1::StepSheetsRequest far = request_of({"a", "b"}, 1);
  v1::Probe& probe = *far.add_probes();
  probe.set_name("far");
  probe.set_quantity(v1::Probe::POSITION);
  probe.add_points()->set_x(7.0);
  EXPECT_EQ(refusal(far), "POINT_OUTSIDE probes[0].points[0]");
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/ResumeSheet", R"({"name":"sheets/c"})").ok());
  EXPECT_EQ(refusal(request_of({"a", "b", "c"}, 1)), "NOT_PAUSED names[2]");
  EXPECT_EQ(get_sheet("sheets/a").tick(), 0);
  EXPECT_EQ(get_sheet("sheets/b").tick(), 0);
}

TEST_F(StepSheetsTest, RefusesStatesThatAreTooLarge) {
  Limits limits;
  limits.max_stepped_bytes = 6000;  // One sheet of 7 x 7 vertices, not two.
  make_api(limits, nullptr);
  v1::StepSheetsRequest request = request_of({"a", "b"}, 1);
  request.set_states(true);
  EXPECT_EQ(refusal(request), "STATES_TOO_LARGE states");
  EXPECT_EQ(get_sheet("sheets/a").tick(), 0);
  EXPECT_EQ(refusal(request_of({"a", "b"}, 1)), "") << "without their states";
  request.mutable_names()->RemoveLast();
  EXPECT_EQ(refusal(request), "");
}

TEST_F(StepSheetsTest, JsonHasTheSame) {
  const Result<std::string> reply = call_json(
      "/kerf.v1.SheetService/StepSheets",
      R"({"names":["sheets/a"],"ticks":2,"probes":[{"name":"gap","quantity":"OPENING","points":[{"x":0.5,"y":0.5}]}]})");
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_NE(reply->find(R"("gap.normal")"), std::string::npos) << *reply;
  EXPECT_NE(reply->find(R"("NaN")"), std::string::npos) << "there is no cut";
}

}  // namespace
}  // namespace kerf::api
