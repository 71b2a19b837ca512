#include "server/service/api/request_log.h"

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace kerf::api {
namespace {

TEST(RequestLog, ServesWaitersAndForgetsFailures) {
  RequestLog log(8, 1024);
  std::vector<std::string> seen;
  const auto note = [&seen](const RequestLog::Outcome& outcome) {
    seen.push_back(outcome.ok() ? *outcome : outcome.error().reason);
  };
  EXPECT_TRUE(log.begin("k", RequestLog::hash_of("body"), note));
  EXPECT_FALSE(log.begin("k", RequestLog::hash_of("body"), note));
  EXPECT_FALSE(log.begin("k", RequestLog::hash_of("other"), note));
  EXPECT_EQ(seen, std::vector<std::string>{"REQUEST_ID_REUSED"});
  log.finish("k", Error{ErrorCode::kUnavailable, "BUSY", "", {}});
  EXPECT_EQ(seen.back(), "BUSY");
  EXPECT_TRUE(log.begin("k", RequestLog::hash_of("other"), note)) << "a failure binds nobody";
  log.finish("k", std::string("answer"));
  EXPECT_FALSE(log.begin("k", RequestLog::hash_of("other"), note));
  EXPECT_EQ(seen.back(), "answer");
}

TEST(RequestLog, SaysWhenAllHaveLeftWhoWait) {
  RequestLog log(8, 1024);
  const auto ignore = [](const RequestLog::Outcome&) {};
  std::stop_source first;
  std::stop_source second;
  const std::optional<std::stop_token> all_left =
      log.begin("k", RequestLog::hash_of("body"), ignore, first.get_token());
  ASSERT_TRUE(all_left);
  EXPECT_FALSE(log.begin("k", RequestLog::hash_of("body"), ignore, second.get_token()));
  first.request_stop();
  EXPECT_FALSE(all_left->stop_requested()) << "the second waits";
  second.request_stop();
  EXPECT_TRUE(all_left->stop_requested());
  log.finish("k", Error{ErrorCode::kAborted, "CREATION_ABANDONED", "", {}});
  const std::optional<std::stop_token> again = log.begin("k", RequestLog::hash_of("body"), ignore);
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->stop_requested()) << "a caller without a token stays";
  log.finish("k", std::string("answer"));
}

TEST(RequestLog, KeepsItsLimitOnBytes) {
  RequestLog log(8, 20);
  const auto ask = [&log](const std::string& key, const std::string& answer) {
    std::string seen;
    if (!log.begin(key, RequestLog::hash_of("body"), [&seen](const RequestLog::Outcome& outcome) { seen = *outcome; }))
      return seen;
    log.finish(key, answer);
    return std::string("new");
  };
  EXPECT_EQ(ask("a", std::string(9, 'A')), "new");
  EXPECT_EQ(ask("b", std::string(9, 'B')), "new");
  EXPECT_EQ(ask("a", {}), std::string(9, 'A')) << "twenty bytes are kept";
  EXPECT_TRUE(log.begin("c", RequestLog::hash_of("body"), [](const RequestLog::Outcome&) {}));
  EXPECT_EQ(ask("b", {}), std::string(9, 'B'));
  log.finish("c", std::string());
  EXPECT_EQ(ask("b", {}), std::string(9, 'B')) << "used last";
  EXPECT_EQ(ask("a", std::string(9, 'A')), "new") << "the twenty-first byte was too many";
  EXPECT_EQ(ask("d", std::string(20, 'D')), "new");
  EXPECT_EQ(ask("d", std::string(1, 'd')), "new") << "one that is too large by itself is not kept";
  EXPECT_EQ(ask("d", {}), "d");
}

TEST(RequestLog, RemembersRequestsOfTheServerBefore) {
  RequestLog log(2, 1024);
  std::vector<std::string> seen;
  const auto note = [&seen](const RequestLog::Outcome& outcome) {
    seen.push_back(outcome.ok() ? *outcome : outcome.error().reason);
  };
  ASSERT_TRUE(log.begin("new", RequestLog::hash_of("body"), note));
  log.finish("new", std::string("of today"));
  log.remember("old", RequestLog::hash_of("body"), "of yesterday");
  log.remember("new", RequestLog::hash_of("body"), "of yesterday");
  log.remember("older", RequestLog::hash_of("body"), "too many");
  EXPECT_FALSE(log.begin("old", RequestLog::hash_of("body"), note));
  EXPECT_FALSE(log.begin("old", RequestLog::hash_of("other"), note));
  EXPECT_FALSE(log.begin("new", RequestLog::hash_of("body"), note));
  EXPECT_TRUE(log.begin("older", RequestLog::hash_of("body"), note)) << "the oldest was forgotten";
  log.finish("older", std::string("done"));
  EXPECT_EQ(seen, (std::vector<std::string>{"of yesterday", "REQUEST_ID_REUSED", "of today"}));
}

}  // namespace
}  // namespace kerf::api
