#include "server/service/local/kerf_local.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

// Links the shared library alone, as other languages load it: messages are looked at as bytes.
namespace kerf::local {
namespace {

using testing::HasSubstr;

std::string taken(kerf_local_bytes bytes) {
  std::string text(static_cast<const char*>(bytes.data), bytes.size);
  kerf_local_free(bytes);
  return text;
}

TEST(KerfLocalTest, CallsAnswerWithBytes) {
  kerf_local_bytes answer{};
  kerf_local* const server = kerf_local_start(1, 0, &answer);
  ASSERT_NE(server, nullptr);
  ASSERT_EQ(kerf_local_call(server, "/kerf.v1.ServerService/GetServerInfo", "", 0, -1.0, &answer), 0);
  EXPECT_THAT(taken(answer), HasSubstr("none was started")) << "of the renderer";
  kerf_local_stop(server);
}

TEST(KerfLocalTest, RefusalsAreStatuses) {
  kerf_local_bytes answer{};
  EXPECT_EQ(kerf_local_start(1000, 0, &answer), nullptr);
  EXPECT_THAT(taken(answer), HasSubstr("1 to 256 workers"));
  kerf_local* const server = kerf_local_start(1, 0, &answer);
  EXPECT_EQ(kerf_local_call(server, "/none", "", 0, -1.0, &answer), 5);
  EXPECT_THAT(taken(answer), HasSubstr("has no call /none"));
  EXPECT_EQ(kerf_local_upload_sheet(server, "\xff", 1, "", 0, -1.0, &answer), 3);
  EXPECT_THAT(taken(answer), HasSubstr("MALFORMED_MESSAGE"));
  kerf_local_stop(server);
}

}  // namespace
}  // namespace kerf::local
