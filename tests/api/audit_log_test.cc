// The record of what callers changed.

#include "server/service/api/audit_log.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

using nlohmann::json;

auth::Caller alice() {
  return {std::make_shared<const auth::Grant>("alice", auth::Rights{auth::Scope::kCut, "lab-*", 0, "lab"},
                                              [] { return std::int64_t{5}; }),
          "192.0.2.7:4711"};
}

class AuditLogTest : public ::testing::Test {
 protected:
  test::ManualClock clock_;
  std::vector<std::string> lines_;
  bool has_room_ = true;
  AuditLog log_{[this](std::string_view line) {
                  if (has_room_) lines_.emplace_back(line);
                  return has_room_;
                },
                clock_};
};

TEST_F(AuditLogTest, ALineSaysWhoDidWhatFromWhere) {
  log_.add({alice(), "CreateCut", "lab-1", "id-1"}, Nothing{});
  log_.add({alice(), "CreateCut", "lab-1", ""}, resource_exhausted("QUEUE_FULL", "full"));
  ASSERT_EQ(lines_.size(), 2u);
  EXPECT_EQ(lines_[0].find('\n'), lines_[0].size() - 1);
  const json first = json::parse(lines_[0]), second = json::parse(lines_[1]);
  EXPECT_EQ(first.at("call"), "CreateCut");
  EXPECT_EQ(first.at("outcome"), "OK");
  EXPECT_EQ(first.at("token_id"), "alice");
  EXPECT_EQ(first.at("tenant"), "lab");
  EXPECT_EQ(first.at("address"), "192.0.2.7:4711");
  EXPECT_EQ(first.at("sheet"), "lab-1");
  EXPECT_EQ(first.at("request_id"), "id-1");
  EXPECT_EQ(first.at("left_out"), "0");
  EXPECT_TRUE(first.at("time").is_string());
  EXPECT_EQ(second.at("outcome"), "QUEUE_FULL");
}

TEST_F(AuditLogTest, RefusalsOfEachTokenAreLimitedAndCounted) {
  const Error unknown = unauthenticated("TOKEN_UNKNOWN", "no");
  for (int i = 0; i < 500; ++i) log_.add({auth::everybody(), "Authorize", "", ""}, unknown);
  EXPECT_EQ(lines_.size(), 60u);
  log_.add({alice(), "DeleteSheet", "lab-1", ""}, permission_denied("SCOPE_TOO_LOW", "no"));
  ASSERT_EQ(lines_.size(), 61u) << "strangers do not hide what a token tries";
  EXPECT_EQ(json::parse(lines_.back()).at("left_out"), "440");
  for (int i = 0; i < 500; ++i) log_.add({alice(), "CreateCut", "lab-1", ""}, Nothing{});
  EXPECT_EQ(lines_.size(), 561u) << "changes are never left out";
  clock_.move_to(clock_.now() + std::chrono::minutes(1));
  for (int i = 0; i < 100; ++i) log_.add({auth::everybody(), "Authorize", "", ""}, unknown);
  EXPECT_EQ(lines_.size(), 621u);
}

TEST_F(AuditLogTest, LongNamesAreCut) {
  log_.add({alice(), "CreateCut", std::string(1'000'000, '\1'), std::string(63, 'a') + "\u00e9\u00e9"},
           permission_denied("SCOPE_TOO_LOW", "no"));
  EXPECT_LT(lines_.at(0).size(), 1000u);
  EXPECT_EQ(json::parse(lines_[0]).at("request_id"), std::string(63, 'a') + "...");
}

TEST_F(AuditLogTest, CountsWhatCouldNotBeWritten) {
  has_room_ = false;
  for (int i = 0; i < 3; ++i) log_.add({alice(), "CreateCut", "lab-1", ""}, Nothing{});
  has_room_ = true;
  log_.add({alice(), "CreateCut", "lab-1", ""}, Nothing{});
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_EQ(json::parse(lines_[0]).at("left_out"), "3");
}

class AuditedApiTest : public ApiTest {
 protected:
  AuditedApiTest() {
    authenticator_ = std::make_unique<auth::Authenticator>([] { return std::int64_t{1000}; });
    authenticator_->set_tokens(auth::parse_token_file(alice_.line).value().tokens);
    audit_ = std::make_unique<AuditLog>(
        [this](std::string_view line) {
          lines_.push_back(json::parse(line));
          return true;
        },
        clock_);
    make_api({}, nullptr);
    caller_ = api_->caller_of("Bearer " + alice_.text, "192.0.2.7:4711").value();
  }
  // Returns what the lines say since the last call: call, sheet and outcome of each.
  std::vector<std::string> said() {
    std::vector<std::string> texts;
    for (const json& line : std::exchange(lines_, {})) {
      texts.push_back(line.at("call").get<std::string>() + " " + line.at("sheet").get<std::string>() + " " +
                      line.at("outcome").get<std::string>());
    }
    return texts;
  }

  const auth::NewToken alice_ = auth::make_token({"alice", auth::Scope::kCut, "lab-*", "", ""}).value();
  std::vector<json> lines_;
};

TEST_F(AuditedApiTest, HasChangesAndRefusalsButNotReads) {
  ASSERT_TRUE(create_sheet("lab-1", true).ok());
  EXPECT_TRUE(call_json("/kerf.v1.SheetService/GetSheet", R"({"name":"sheets/lab-1"})").ok());
  EXPECT_FALSE(call_json("/kerf.v1.SheetService/GetSheet", R"({"name":"sheets/a"})").ok());
  EXPECT_THAT(said(), ::testing::ElementsAre()) << "the fixture calls the method itself";
  EXPECT_TRUE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/lab-1"})").ok());
  EXPECT_FALSE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/lab-2"})").ok());
  EXPECT_FALSE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/a"})").ok());
  EXPECT_FALSE(call_json("/kerf.v1.SheetService/DeleteSheet", R"({"name":"sheets/lab-1"})").ok());
  EXPECT_TRUE(call_json("/kerf.v1.AccessService/CreateLink", R"({"sheet_id":"lab-1"})").ok());
  EXPECT_TRUE(call_json("/kerf.v1.CutService/CreateCut",
                        R"({"parent":"sheets/lab-1","cut":{"curve":{"polyline":{"points":[{"x":5},{"x":6}]}}}})")
                  .ok());
  EXPECT_EQ(lines_.at(0).at("address"), "192.0.2.7:4711");
  EXPECT_THAT(said(), ::testing::ElementsAre("ResetSheet lab-1 OK", "ResetSheet lab-2 SHEET_NOT_FOUND",
                                             "ResetSheet a SHEET_NOT_FOUND", "DeleteSheet lab-1 SCOPE_TOO_LOW",
                                             "CreateLink lab-1 OK", "CreateCut lab-1 NO_INTERSECTION"));
}

TEST_F(AuditedApiTest, NamesATokenThatHasEnded) {
  const auth::NewToken bob = auth::make_token({"bob", auth::Scope::kCut, "", "1971-01-02", ""}).value();
  authenticator_ = std::make_unique<auth::Authenticator>([] { return std::int64_t{1} << 40; });
  authenticator_->set_tokens(auth::parse_token_file(bob.line).value().tokens);
  make_api({}, nullptr);
  EXPECT_FALSE(api_->caller_of("Bearer " + bob.text, "192.0.2.8").ok());
  EXPECT_EQ(lines_.at(0).at("token_id"), "bob");
  EXPECT_EQ(lines_.at(0).at("outcome"), "TOKEN_EXPIRED");
}

TEST_F(AuditedApiTest, HasTokensThatAreRefused) {
  EXPECT_FALSE(api_->caller_of("Bearer kerf_alice_guess", "192.0.2.8:1").ok());
  EXPECT_FALSE(api_->caller_of("", "192.0.2.8:2").ok());
  ASSERT_EQ(lines_.size(), 1u) << "a caller without a token has guessed none";
  EXPECT_EQ(lines_[0].at("address"), "192.0.2.8:1");
  EXPECT_EQ(lines_[0].at("token_id"), "");
  EXPECT_THAT(said(), ::testing::ElementsAre("Authorize  TOKEN_UNKNOWN"));
}

}  // namespace
}  // namespace kerf::api
