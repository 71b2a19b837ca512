// JSON, and errors.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/run.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/base/random.h"
#include "server/service/wire/error_codec.h"
#include "server/service/wire/json.h"
#include "tests/wire/codec_checks.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

using testing::full_scene;
using ::testing::HasSubstr;

TEST(ErrorCodec, StatusHasTheStandardDetails) {
  google::rpc::Status status;
  const Error bad = invalid_argument("CURVE_NOT_FINITE", "x is not finite", "cut.curve.circle.center.x");
  ASSERT_TRUE(status.ParseFromString(encode_status(bad)));
  EXPECT_EQ(status.code(), 3);
  EXPECT_EQ(status.message(), "x is not finite");
  ASSERT_EQ(status.details_size(), 2);
  google::rpc::ErrorInfo info;
  ASSERT_TRUE(status.details(0).UnpackTo(&info));
  EXPECT_EQ(info.reason(), "CURVE_NOT_FINITE");
  EXPECT_EQ(info.domain(), "kerf");
  google::rpc::BadRequest request;
  ASSERT_TRUE(status.details(1).UnpackTo(&request));
  EXPECT_EQ(request.field_violations(0).field(), "cut.curve.circle.center.x");

  const Error full{ErrorCode::kResourceExhausted, "QUEUE_FULL", "64 commands wait", {}};
  ASSERT_TRUE(status.ParseFromString(encode_status(full)));
  EXPECT_EQ(status.code(), 8);
  google::rpc::RetryInfo retry;
  ASSERT_EQ(status.details_size(), 2);
  ASSERT_TRUE(status.details(1).UnpackTo(&retry));
  EXPECT_EQ(retry.retry_delay().nanos(), 100'000'000);
  EXPECT_THAT(error_to_json(full), HasSubstr("\"reason\":\"QUEUE_FULL\""));
  EXPECT_THAT(error_to_json(full), HasSubstr("\"retry_delay\":\"0.100s\""));

  const Error beyond{ErrorCode::kResourceExhausted, "TENANT_STATES", "too many", "tenant:lab"};
  ASSERT_TRUE(status.ParseFromString(encode_status(beyond)));
  ASSERT_EQ(status.details_size(), 2);
  google::rpc::QuotaFailure quota;
  ASSERT_TRUE(status.details(1).UnpackTo(&quota));
  EXPECT_EQ(quota.violations(0).subject(), "tenant:lab");

  const Error stalled{ErrorCode::kUnavailable, "STORAGE_STALLED", "too much waits to be written", {}};
  ASSERT_TRUE(status.ParseFromString(encode_status(stalled)));
  EXPECT_EQ(status.details_size(), 2) << "the disk may be back soon";
  const Error stopping{ErrorCode::kUnavailable, "SERVER_STOPPING", "the server is stopping", {}};
  ASSERT_TRUE(status.ParseFromString(encode_status(stopping)));
  EXPECT_EQ(status.details_size(), 1);

  const Error never{ErrorCode::kResourceExhausted, "CUT_ELEMENT_BUDGET", "more triangles than allowed", {}};
  ASSERT_TRUE(status.ParseFromString(encode_status(never)));
  EXPECT_EQ(status.details_size(), 1) << "the same cut will be refused again";
}

TEST(ErrorCodec, CodesAreThoseOfGrpc) {
  EXPECT_EQ(status_code(ErrorCode::kNotFound), 5);
  EXPECT_EQ(status_code(ErrorCode::kAlreadyExists), 6);
  EXPECT_EQ(status_code(ErrorCode::kFailedPrecondition), 9);
  EXPECT_EQ(status_code(ErrorCode::kAborted), 10);
  EXPECT_EQ(status_code(ErrorCode::kPermissionDenied), 7);
  EXPECT_EQ(status_code(ErrorCode::kUnauthenticated), 16);
  EXPECT_EQ(status_code(ErrorCode::kInternal), 13);
  EXPECT_EQ(status_code(ErrorCode::kUnavailable), 14);
  EXPECT_EQ(status_code(ErrorCode::kDataLoss), 15);
  EXPECT_EQ(status_name(ErrorCode::kDataLoss), "DATA_LOSS");
}

TEST(Json, SceneComesBackUnchangedInBothSpellings) {
  const v1::Scene scene = full_scene();
  const std::string json = to_json(scene);
  EXPECT_THAT(json, HasSubstr("\"tick_rate_hz\":"));
  v1::Scene back;
  ASSERT_TRUE(from_json(json, back).ok());
  expect_equal(back, scene);
  ASSERT_TRUE(from_json(R"({"tickRateHz": 30, "grid": {"widthM": 2.5}})", back).ok());
  EXPECT_EQ(back.tick_rate_hz(), 30.0);
  EXPECT_EQ(back.grid().width_m(), 2.5);
}

TEST(Json, DefaultsArePrinted) {
  const std::string json = to_json(v1::CutResult());
  EXPECT_THAT(json, HasSubstr("\"new_vertices\":0"));
  EXPECT_THAT(json, HasSubstr("\"state_hash\":\"\""));
}

TEST(Json, AByteOrderMarkIsPassedOver) {
  v1::Scene scene;
  ASSERT_TRUE(from_json("\xEF\xBB\xBF{\"sheet_id\": \"a\"}", scene).ok());
  EXPECT_EQ(scene.sheet_id(), "a");
  EXPECT_FALSE(from_json("\xEF\xBB{}", scene).ok());
}

struct BadJson {
  const char* text;
  const char* reason;
  const char* field;
  const char* where;
};

TEST(Json, FaultsNameLineColumnAndField) {
  const std::vector<BadJson> cases = {
      {"{\n  \"grid\": {\"colums\": 3}\n}", "JSON_UNKNOWN_FIELD", "grid.colums", "line 2, column 12"},
      {"{\"pins\": [{\"edge\": \"TOP\"},\n {\"edge\": \"TOPP\"}]}", "JSON_TYPE", "pins[1].edge", "line 2, column 11"},
      {"{\"grid\": {\"columns\": 3.5}}", "JSON_TYPE", "grid.columns", "line 1, column 22"},
      {"{\"grid\": {\"columns\": 3000000000}}", "JSON_TYPE", "grid.columns", "line 1"},
      {"{\"grid\": {\"columns\": \"many\"}}", "JSON_TYPE", "grid.columns", "line 1"},
      {"{\"grid\": 3}", "JSON_TYPE", "grid", "line 1, column 10"},
      {"{\"pins\": {}}", "JSON_TYPE", "pins", "line 1"},
      {"{\"sheet_id\": 3}", "JSON_TYPE", "sheet_id", "line 1"},
      {"{\"tick_rate_hz\": [1]}", "JSON_TYPE", "tick_rate_hz", "line 1"},
      {"{\"sheet_id\": \"a\", \"sheetId\": \"b\"}", "JSON_DUPLICATE_FIELD", "sheet_id", "line 1, column 19"},
      {"{\"grid\": {},\n\"obj\": {}}", "JSON_DUPLICATE_FIELD", "obj", "line 2, column 1"},
      {"{\"grid\": {}", "JSON_SYNTAX", "", "line 1, column 12"},
      {"{\"grid\": {} \"obj\": {}}", "JSON_SYNTAX", "", "expected , or }"},
      {"{\"grid\" {}}", "JSON_SYNTAX", "grid", "expected :"},
      {"{} {}", "JSON_SYNTAX", "", "after the end"},
      {"{\"sheet_id\": \"a", "JSON_SYNTAX", "sheet_id", "that does not end"},
      {"", "JSON_TYPE", "", "line 1, column 1"},
      {"[]", "JSON_TYPE", "", "expected an object"},
      {"{\"grid\": {\"columns\": 3,}}", "JSON_SYNTAX", "grid", "line 1, column 24: grid: a comma before }"},
      {"{\"pins\": [{},]}", "JSON_SYNTAX", "pins", "a comma before ]"},
      {"{'grid': {}}", "JSON_SYNTAX", "", "expected a name in double quotes, found '"},
      {"{\"ply\": {\"data\": \"no base64!\"}}", "JSON_TYPE", "ply.data", "a string in base64, found \"no base64!\""},
      {"{\"sheet_id\":\n \"\xc3\xb6\xff\"}", "JSON_SYNTAX", "", "line 2, column 5: a byte that is not UTF-8"},
      {"\x1f\x8b\x08", "JSON_SYNTAX", "", "compressed by gzip"},
  };
  for (const BadJson& bad : cases) {
    v1::Scene scene;
    const Status status = from_json(bad.text, scene);
    ASSERT_FALSE(status.ok()) << bad.text;
    EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(status.error().reason, bad.reason) << bad.text << ": " << status.error().message;
    EXPECT_EQ(status.error().field, bad.field) << bad.text << ": " << status.error().message;
    EXPECT_THAT(status.error().message, HasSubstr(bad.where)) << bad.text;
  }
}

TEST(Json, ValuesInMessagesAreShort) {
  v1::CreateSheetRequest request;
  EXPECT_THAT(from_json("{\"paused\": \"true\"}", request).error().message, HasSubstr("true or false, found \"true\""));
  const std::string message = from_json("{\"paused\": \"" + std::string(5'000, 'x') + "\"}", request).error().message;
  EXPECT_LT(message.size(), 200U);
  EXPECT_TRUE(from_json(R"({"scene": {"ply": {"data": "cGx5Cg=="}}})", request).ok());
  EXPECT_TRUE(from_json(R"({"scene": {"ply": {"data": "\/\/8="}}})", request).ok());
  EXPECT_FALSE(from_json(R"({"scene": {"ply": {"data": "a b"}}})", request).ok());
}

TEST(Json, NoTruncationOrByteFlipGetsThroughUnnoticedOrCrashes) {
  const std::string json = to_json(full_scene());
  v1::Scene scene;
  for (std::size_t length = 0; length < json.size(); length += 7) {
    EXPECT_FALSE(from_json(std::string_view(json).substr(0, length), scene).ok()) << length;
  }
  SeededRandom random(9);
  for (int round = 0; round < 2000; ++round) {
    std::string damaged = json;
    damaged[random.below(damaged.size())] = static_cast<char>(random.below(256));
    const Status status = from_json(damaged, scene);
    EXPECT_TRUE(status.ok() || status.error().code == ErrorCode::kInvalidArgument);
  }
}

TEST(Json, MapsAreObjectsWhoseNamesAreFree) {
  v1::RunResult result;
  (*result.mutable_flagged_ticks())["substepped"] = 3;
  (*result.mutable_flagged_ticks())["not_converged"] = 12;
  v1::RunResult read;
  ASSERT_TRUE(from_json(to_json(result), read).ok());
  // Not by MessageDifferencer: under the thread sanitizer maps have another layout than in Debian's library, which it
  // reads.
  ASSERT_EQ(read.flagged_ticks_size(), 2);
  EXPECT_EQ(read.flagged_ticks().at("substepped"), 3);
  EXPECT_EQ(read.flagged_ticks().at("not_converged"), 12);
  ASSERT_TRUE(from_json(R"({"flagged_ticks": {}})", read).ok());
  EXPECT_TRUE(read.flagged_ticks().empty());
  const auto refusal = [](const char* json) {
    v1::RunResult message;
    const Status status = from_json(json, message);
    return status.ok() ? "fine" : status.error().reason + " " + status.error().field;
  };
  EXPECT_EQ(refusal(R"({"flagged_ticks": {"a": 1.5}})"), "JSON_TYPE flagged_ticks.a");
  EXPECT_EQ(refusal(R"({"flagged_ticks": {"a": 1, "a": 2}})"), "JSON_DUPLICATE_FIELD flagged_ticks.a");
  EXPECT_EQ(refusal(R"({"flagged_ticks": [1]})"), "JSON_TYPE flagged_ticks");
  EXPECT_EQ(refusal(R"({"flagged_ticks": {"a" 1}})"), "JSON_SYNTAX flagged_ticks.a");
}

TEST(Json, NotANumberReachesValidation) {
  const Result<scene::SheetConfig> config =
      decode_scene_file(R"({"grid": {"columns": 3, "rows": 3, "width_m": "NaN", "height_m": 1}})", {});
  ASSERT_FALSE(config.ok());
  EXPECT_EQ(config.error().field, "grid.width_m");
}

}  // namespace
}  // namespace kerf::wire
