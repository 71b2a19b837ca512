#include "server/service/local/kerf_local.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "google/rpc/status.pb.h"
#include "kerf/v1/server.pb.h"

namespace kerf::local {
namespace {

using testing::HasSubstr;

std::string taken(kerf_local_bytes bytes) {
  std::string text(static_cast<const char*>(bytes.data), bytes.size);
  kerf_local_free(bytes);
  return text;
}

google::rpc::Status status_in(kerf_local_bytes bytes) {
  google::rpc::Status status;
  EXPECT_TRUE(status.ParseFromString(taken(bytes)));
  return status;
}

TEST(KerfLocalTest, CallsAnswerWithBytes) {
  kerf_local_bytes answer{};
  kerf_local* const server = kerf_local_start(1, 0, &answer);
  ASSERT_NE(server, nullptr);
  ASSERT_EQ(kerf_local_call(server, "/kerf.v1.ServerService/GetServerInfo", "", 0, -1.0, &answer), 0);
  v1::ServerInfo info;
  ASSERT_TRUE(info.ParseFromString(taken(answer)));
  EXPECT_EQ(info.workers(), 1);
  EXPECT_THAT(info.renderer(), HasSubstr("none"));
  kerf_local_stop(server);
}

TEST(KerfLocalTest, RefusalsAreStatuses) {
  kerf_local_bytes answer{};
  EXPECT_EQ(kerf_local_start(1000, 0, &answer), nullptr);
  EXPECT_THAT(status_in(answer).message(), HasSubstr("1 to 256 workers"));
  kerf_local* const server = kerf_local_start(1, 0, &answer);
  EXPECT_EQ(kerf_local_call(server, "/none", "", 0, -1.0, &answer), 5);
  EXPECT_THAT(status_in(answer).message(), HasSubstr("has no call /none"));
  EXPECT_EQ(kerf_local_upload_sheet(server, "\xff", 1, "", 0, &answer), 3);
  EXPECT_EQ(status_in(answer).code(), 3);
  kerf_local_stop(server);
}

}  // namespace
}  // namespace kerf::local
