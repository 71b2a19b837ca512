#include "client/load/run.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cpp/client.h"
#include "client/load/sheet_set.h"
#include "tests/support/closed_port.h"
#include "tests/ws/running_server.h"

// Short runs against a whole server: counts, not times.
namespace kerf::load {
namespace {

using testing::HasSubstr;

class LoadRunTest : public testing::Test {
 protected:
  LoadRunTest() { server_ = ws_test::start_server(config()); }

  static app::Config config() {
    app::Config config = ws_test::test_config();
    config.max_sheets = 3;
    return config;
  }

  [[nodiscard]] Plan plan() const {
    Plan plan;
    plan.server = server_->grpc_address();
    plan.http = server_->http_url().substr(std::string("http://").size());
    plan.columns = 8;
    plan.rows = 8;
    plan.warm_up_s = 0.0;
    plan.duration_s = 1.0;
    return plan;
  }

  std::int32_t sheets_left() {
    client::Client client(server_->grpc_address());
    v1::ServerInfo info;
    EXPECT_TRUE(
        client.call(&v1::ServerService::Stub::GetServerInfo, client.server(), v1::GetServerInfoRequest(), info).ok());
    return info.num_sheets();
  }

  Result<Report> run(const Plan& plan) {
    Stopper stopper;
    return load::run(
        plan, [](const Progress&) {}, stopper);
  }

  std::unique_ptr<app::Server> server_;
};

TEST_F(LoadRunTest, CountsWhatItDoesAndLeavesNothingBehind) {
  Plan wanted = plan();
  wanted.sheets = 2;
  wanted.viewers = 3;
  wanted.slow_readers = 1;
  wanted.hold_s = 0.3;
  wanted.cuts_per_second = 10.0;
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(sheets_left(), 0);
  ASSERT_EQ(report->sheets.size(), 2U);
  for (const SheetRun& sheet : report->sheets) {
    EXPECT_EQ(sheet.run_state, "RUNNING");
    EXPECT_GT(sheet.ticks, 0);
  }
  const ReaderTotals& viewers = report->of(Role::kViewer);
  EXPECT_EQ(viewers.readers, 3);
  EXPECT_TRUE(viewers.ends.empty());
  EXPECT_GT(viewers.frames, 0);
  EXPECT_EQ(viewers.age_us.count(), viewers.frames);
  EXPECT_GT(viewers.shown_us.count(), 0);
  EXPECT_LE(viewers.shown_us.count(), 3 * 60);
  EXPECT_EQ(viewers.join_us.count(), 3);
  const ReaderTotals& slow = report->of(Role::kSlow);
  EXPECT_EQ(slow.readers, 1);
  EXPECT_LE(slow.frames, 5);  // one every 0.3 s
  EXPECT_EQ(report->cuts.sent, 10);
  EXPECT_EQ(report->cuts.applied + report->cuts.missed, 10);
  EXPECT_EQ(report->cuts.undone, report->cuts.applied);
  EXPECT_EQ(report->cuts.reply_us.count(), 10);
  EXPECT_EQ(report->cuts.seen_us.count(), report->cuts.applied);
  EXPECT_EQ(report->cuts.unseen, 0);
  EXPECT_EQ(report->cuts.seen_without, 0);
  EXPECT_EQ(num_errors(*report), 0) << to_text(*report);
  EXPECT_GT(report->control_us.count(), 0);
  EXPECT_GE(report->probes.size(), 2U);
  EXPECT_GE(server_cores(*report), 0.0);  // from the page of metrics
}

TEST_F(LoadRunTest, ViewersComeAndGoInStages) {
  Plan wanted = plan();
  wanted.sheets = 2;
  wanted.cuts_per_second = 10.0;
  wanted.cut_kind = CutKind::kMixed;
  set_stages(*parse_stages("400ms:4,600ms:4,400ms:0"), Staged::kViewers, wanted);
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  const ReaderTotals& viewers = report->of(Role::kViewer);
  EXPECT_GT(viewers.readers, 0);
  EXPECT_LE(viewers.readers, 4) << "None opened twice.";
  EXPECT_TRUE(viewers.ends.empty());
  EXPECT_EQ(report->cuts.sent, 14);
  EXPECT_EQ(report->cuts.applied, 14) << "Each kind of cut lies inside the sheet.";
  EXPECT_EQ(num_errors(*report), 0) << to_text(*report);
  EXPECT_THAT(to_text(*report), HasSubstr("stages     of viewers: 0.4s:4,0.6s:4,0.4s:0"));
  std::int64_t answered = 0;
  for (const Stretch& stretch : report->stretches) answered += stretch.cut_us.count();
  EXPECT_EQ(answered, 14);
}

TEST_F(LoadRunTest, SheetsRunInStages) {
  Plan wanted = plan();
  wanted.viewers = 2;
  wanted.cuts_per_second = 10.0;
  set_stages(*parse_stages("0s:3,0s:2,1500ms:2,0s:1,500ms:1"), Staged::kSheets, wanted);
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  ASSERT_EQ(report->sheets.size(), 3U);
  EXPECT_GT(report->sheets[1].ticks, 0);
  EXPECT_LT(report->sheets[1].ticks, report->sheets[0].ticks);
  EXPECT_EQ(report->sheets[2].real_time_factor, 0.0) << "It ran for too short a time.";
  EXPECT_EQ(pace_of(*report).running, 2);
  EXPECT_EQ(num_errors(*report), 0) << to_text(*report);
  EXPECT_EQ(sheets_left(), 0);
}

TEST_F(LoadRunTest, NothingIsCutWhileNoSheetRuns) {
  Plan wanted = plan();
  wanted.cuts_per_second = 20.0;
  set_stages(*parse_stages("320ms:0,0s:1,0s:0,180ms:0"), Staged::kSheets, wanted);
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->cuts.sent, 0);
  EXPECT_EQ(report->sheets[0].run_state, "PAUSED");
}

TEST_F(LoadRunTest, WebSocketsDoTheSame) {
  Plan wanted = plan();
  wanted.transport = Transport::kWebSocket;
  wanted.sheets = 2;
  wanted.viewers = 3;
  wanted.stalled_readers = 1;
  wanted.cuts_per_second = 10.0;
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  const ReaderTotals& viewers = report->of(Role::kViewer);
  EXPECT_EQ(viewers.readers, 3);
  EXPECT_TRUE(viewers.ends.empty()) << viewers.ends.begin()->first;
  EXPECT_GT(viewers.frames, 0);
  EXPECT_EQ(report->of(Role::kStalled).readers, 1);
  EXPECT_EQ(report->of(Role::kStalled).join_us.count(), 1);
  EXPECT_EQ(report->cuts.sent, 10);
  EXPECT_EQ(report->cuts.seen_without, 0);
  EXPECT_EQ(num_errors(*report), 0) << to_text(*report);
}

// The server gives them up, they read of it once they wake, and the others never notice.
class LoadRunOver : public LoadRunTest, public testing::WithParamInterface<Transport> {};

TEST_P(LoadRunOver, StalledReadersTellHowTheyWereEnded) {
  app::Config impatient = config();
  impatient.limits.watch_ack_timeout = std::chrono::seconds(2);
  server_ = ws_test::start_server(impatient);
  Plan wanted = plan();
  wanted.transport = GetParam();
  wanted.stalled_readers = 4;
  wanted.stall_s = 5.0;
  wanted.duration_s = 7.0;
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  const ReaderTotals& stalled = report->of(Role::kStalled);
  EXPECT_EQ(stalled.readers, 4);
  EXPECT_EQ(stalled.ends, (std::map<std::string, std::int64_t>{{"TOO_SLOW", 4}})) << to_text(*report);
  EXPECT_TRUE(report->of(Role::kViewer).ends.empty()) << to_text(*report);
  EXPECT_EQ(num_errors(*report), 0) << to_text(*report);
}

INSTANTIATE_TEST_SUITE_P(Transports, LoadRunOver, testing::Values(Transport::kGrpc, Transport::kWebSocket));

TEST_F(LoadRunTest, TellsOfSheetsThatAreRefused) {
  Plan wanted = plan();
  wanted.sheets = 5;
  wanted.duration_s = 0.1;
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->sheets.size(), 3U);
  EXPECT_GE(report->refusals.at("TOO_MANY_SHEETS"), 1);
  EXPECT_THAT(report->first_refusal, HasSubstr("limit of 3 sheets"));
  EXPECT_EQ(sheets_left(), 0);
}

// The server takes no sheets, now or later. Its time passes in seconds.
TEST_F(LoadRunTest, AServerThatStaysOverloadedIsGivenUp) {
  class Hasty : public Waiter {
   public:
    [[nodiscard]] Nanoseconds now() const override { return std::chrono::seconds(++seconds_); }
    bool wait_until(Nanoseconds /*time*/) override { return true; }

   private:
    mutable std::atomic<std::int64_t> seconds_{0};
  };
  app::Config busy = config();
  busy.max_load = 1e-9;
  server_ = ws_test::start_server(busy);
  Plan wanted = plan();
  wanted.still = true;
  wanted.sheets = 2;
  wanted.prefix = "still";
  client::Client client(server_->grpc_address());
  Hasty hasty;
  const SheetSet moving(plan(), client, hasty, [](const char* /*stage*/, double /*share*/) {});
  std::vector<double> told;
  const SheetSet sheets(wanted, client, hasty, [&](const char* /*stage*/, double share) { told.push_back(share); });
  EXPECT_TRUE(sheets.names().empty());
  EXPECT_EQ(sheets.refusals().begin()->first, "OVERLOADED");
  EXPECT_FALSE(told.empty());
}

TEST_F(LoadRunTest, SheetsOfAStillPlanFallAsleep) {
  Plan wanted = plan();
  wanted.sheets = 3;
  wanted.still = true;
  wanted.viewers = 0;
  wanted.warm_up_s = 4.0;
  wanted.duration_s = 0.2;
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  ASSERT_EQ(report->sheets.size(), 3U);
  for (const SheetRun& sheet : report->sheets) {
    EXPECT_EQ(sheet.run_state, "SLEEPING");
    EXPECT_EQ(sheet.ticks, 0);
  }
}

TEST_F(LoadRunTest, AStoppedRunDeletesItsSheetsToo) {
  Plan wanted = plan();
  wanted.sheets = 2;
  wanted.duration_s = 600.0;
  Stopper stopper;
  const Result<Report> report = load::run(
      wanted,
      [&](const Progress& progress) {
        if (progress.stage == "measuring") stopper.stop();
      },
      stopper);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_TRUE(report->interrupted);
  EXPECT_EQ(sheets_left(), 0);
}

TEST_F(LoadRunTest, WhatCannotBeDoneIsToldBeforeAnythingIsMade) {
  Plan wrong = plan();
  wrong.sheets = 0;
  EXPECT_EQ(run(wrong).error().field, "--sheets");
  Plan taken = plan();
  taken.sheets = 2;
  client::Client client(server_->grpc_address());
  v1::CreateSheetRequest request;
  request.set_sheet_id("load-1");
  request.mutable_scene()->mutable_grid()->set_columns(4);
  request.mutable_scene()->mutable_grid()->set_rows(4);
  request.mutable_scene()->mutable_grid()->set_width_m(1.0);
  request.mutable_scene()->mutable_grid()->set_height_m(1.0);
  v1::Sheet sheet;
  ASSERT_TRUE(client.call(&v1::SheetService::Stub::CreateSheet, client.sheets(), request, sheet).ok());
  EXPECT_EQ(run(taken).error().reason, "SHEET_EXISTS");
  EXPECT_EQ(sheets_left(), 1);  // that one
  const test::ClosedPort nobody;
  Plan nowhere = plan();
  nowhere.server = nobody.address();
  EXPECT_THAT(run(nowhere).error().message, HasSubstr("no server answers at " + nobody.address()));
}

// 20 ms each way: no frame is younger than that, none is lost, and with more of them under way each tick is seen.
TEST_F(LoadRunTest, FramesFromFarAwayAreOlderByTheWay) {
  Plan wanted = plan();
  wanted.way_ms = 20.0;
  wanted.cuts_per_second = 4.0;
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  const ReaderTotals& viewers = report->of(Role::kViewer);
  EXPECT_GT(viewers.frames, 0);
  EXPECT_GE(viewers.age_us.min(), 20'000);
  EXPECT_GE(viewers.join_us.min(), 40'000);  // there and back
  EXPECT_EQ(report->cuts.seen_without, 0);
  EXPECT_EQ(num_errors(*report), 0);
}

// Those of the last 0.6 s are on their way when the run ends.
TEST_F(LoadRunTest, TheLastCutsAreWaitedFor) {
  Plan wanted = plan();
  wanted.way_ms = 600.0;
  wanted.cuts_per_second = 10.0;
  const Result<Report> report = run(wanted);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->cuts.unseen, 0);
  EXPECT_EQ(report->cuts.seen_us.count(), report->cuts.applied);
  EXPECT_GE(report->cuts.seen_us.min(), 600'000);
}

}  // namespace
}  // namespace kerf::load
