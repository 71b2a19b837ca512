#include <chrono>
#include <csignal>
#include <string>

#include <gtest/gtest.h>

#include "client/cpp/client.h"
#include "kerf/v1/server.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/service/wire/json.h"
#include "tests/rpc/kerfd_process.h"
#include "tests/support/sanitizer.h"

// Sheets that take long to build, or for which there is no memory.
namespace kerf::rpc_test {
namespace {

// Takes ten seconds and two GB to build: 404,244 vertices.
constexpr const char* kLargeOutline = R"({"sheet_id": "x", "paused": true, "scene": {"outline": {"boundary":
  {"circle": {"center": {"x": 0.5, "y": 0.5}, "radius_m": 0.5}}, "edge_length_m": 0.0015}}})";
constexpr const char* kSmallGrid = R"({"sheet_id": "x", "paused": true, "scene":
  {"grid": {"columns": 5, "rows": 5, "width_m": 1, "height_m": 1}}})";

class KerfdCreationTest : public KerfdTest {
 protected:
  static grpc::Status create(client::Client& client, const std::string& json,
                             std::chrono::milliseconds timeout = std::chrono::seconds(20)) {
    v1::CreateSheetRequest request;
    EXPECT_TRUE(wire::from_json(json, request).ok());
    v1::Sheet sheet;
    return client.call(&v1::SheetService::Stub::CreateSheet, client.sheets(), request, sheet, timeout);
  }
};

TEST_F(KerfdCreationTest, WhatIsBuiltEndsWithTheClientAndWithTheServer) {
  Kerfd kerfd(free_ports());
  const auto [grpc, http] = ports(kerfd);
  client::Client client("127.0.0.1:" + std::to_string(grpc));
  EXPECT_EQ(create(client, kLargeOutline, std::chrono::milliseconds(200)).error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
  const auto begin = std::chrono::steady_clock::now();
  grpc::Status taken = create(client, kSmallGrid);
  while (taken.error_code() == grpc::StatusCode::ALREADY_EXISTS) taken = create(client, kSmallGrid);
  EXPECT_TRUE(taken.ok()) << taken.error_message();
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - begin;
  RecordProperty("seconds_until_the_name_was_free", std::to_string(waited.count()));

  const std::string running = R"({"sheet_id": "y", "scene": {"grid": {"columns": 700, "rows": 700, "width_m": 1,
    "height_m": 1, "pattern": "JITTERED_DELAUNAY"}}})";
  ws_test::RawClient waiting(http);
  waiting.send("POST /kerf.v1.SheetService/CreateSheet HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
               std::to_string(running.size()) + "\r\n\r\n" + running);
  v1::ServerInfo info;  // whose load counts what is being built
  while (info.load() == 0.0) {
    ASSERT_TRUE(
        client.call(&v1::ServerService::Stub::GetServerInfo, client.server(), v1::GetServerInfoRequest(), info).ok());
  }
  kerfd.signal(SIGTERM);
  EXPECT_EQ(kerfd.wait(), 0);
}

TEST_F(KerfdCreationTest, WithoutMemoryForMoreItRefusesThemAndStaysUp) {
  if (test::runs_with_sanitizer()) GTEST_SKIP() << "the sanitizer reserves more addresses than these";
  Kerfd kerfd(free_ports({"--max-total-vertices", "0"}), "-v 700000");
  const auto [grpc, http] = ports(kerfd);
  client::Client client("127.0.0.1:" + std::to_string(grpc));
  int made = 0;
  grpc::Status status;
  for (int i = 0; i < 20 && status.ok(); ++i) {
    status = create(client, R"({"paused": true, "scene": {"grid": {"columns": 90, "rows": 90, "width_m": 1,
      "height_m": 1}, "integrator": {"kind": "IMPLICIT_EULER", "solver": "DIRECT"}}})");
    made += status.ok() ? 1 : 0;
  }
  EXPECT_EQ(client::failure_of(status).reason, "OUT_OF_MEMORY") << made << " were made";
  EXPECT_TRUE(create(client, kSmallGrid).ok()) << "a small one still fits";
  kerfd.signal(SIGTERM);
  EXPECT_EQ(kerfd.wait(), 0);
}

}  // namespace
}  // namespace kerf::rpc_test
