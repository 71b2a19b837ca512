// Uploads and downloads that stand still, on a clock that the test moves.

#include "server/service/rpc/transfer_deadline.h"

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "client/cpp/transfers.h"
#include "kerf/v1/sheets.grpc.pb.h"
#include "server/service/rpc/rpc_server.h"
#include "server/service/wire/recording_codec.h"
#include "tests/api/fixture.h"

namespace kerf::rpc_test {
namespace {

using namespace std::chrono_literals;
using rpc::TransferDeadline;

class TransferDeadlineTest : public testing::Test {
 protected:
  void begin() {
    deadline_->begin([this](TransferDeadline::Timeout timeout) {
      ++given_up_;
      timeout_ = timeout;
    });
  }

  TransferDeadline::Timeout timeout_{};
  test::ManualClock clock_;
  int given_up_ = 0;
  std::shared_ptr<TransferDeadline> deadline_ =
      std::make_shared<TransferDeadline>(clock_, rpc::TransferTimeouts{30s, 120s});
};

TEST_F(TransferDeadlineTest, EndsOnceWhenNothingComes) {
  begin();
  clock_.move_to(29s);
  EXPECT_EQ(given_up_, 0);
  clock_.move_to(30s);
  EXPECT_EQ(given_up_, 1);
  EXPECT_EQ(timeout_, TransferDeadline::Timeout::kIdle);
  EXPECT_FALSE(deadline_->made_progress());
  EXPECT_FALSE(deadline_->end());
  clock_.move_to(300s);
  EXPECT_EQ(given_up_, 1);
  EXPECT_EQ(clock_.num_timers(), 0U);
}

TEST_F(TransferDeadlineTest, CountsAnewFromWhatComes) {
  begin();
  for (int i = 1; i <= 80; ++i) {
    clock_.move_to(i * 1s);
    ASSERT_TRUE(deadline_->made_progress());
    ASSERT_LE(clock_.num_timers(), 1U);
  }
  clock_.move_to(109s);
  EXPECT_EQ(given_up_, 0);
  clock_.move_to(110s);
  EXPECT_EQ(given_up_, 1);
  EXPECT_EQ(timeout_, TransferDeadline::Timeout::kIdle);
}

TEST_F(TransferDeadlineTest, TheWholeHasALimit) {
  begin();
  for (int i = 1; i < 120; ++i) {
    clock_.move_to(i * 1s);
    ASSERT_TRUE(deadline_->made_progress());
  }
  EXPECT_EQ(given_up_, 0);
  clock_.move_to(120s);
  EXPECT_EQ(given_up_, 1);
  EXPECT_EQ(timeout_, TransferDeadline::Timeout::kTotal);
}

TEST_F(TransferDeadlineTest, AnEndedCallIsLeftAlone) {
  begin();
  EXPECT_TRUE(deadline_->end());
  EXPECT_FALSE(deadline_->end());
  EXPECT_EQ(clock_.num_timers(), 0U);
  deadline_.reset();
  clock_.move_to(60s);
  EXPECT_EQ(given_up_, 0);
}

class UploadTest : public api::ApiTest {
 protected:
  UploadTest() : ApiTest(keeping()) {
    server_ = std::make_unique<rpc::RpcServer>(*api_, clock_);
    address_ = "127.0.0.1:" + std::to_string(server_->start("127.0.0.1:0").value());
    client_ = std::make_unique<client::Client>(address_);
  }

  static host::HostOptions keeping() {
    host::HostOptions options = small_host();
    options.encode_tick = wire::encode_recorded_tick;
    return options;
  }
  // Starts the upload of a mesh file with so many bytes.
  static v1::UploadSheetRequest start_of(std::size_t num_bytes) {
    v1::UploadSheetRequest start;
    start.mutable_start()->mutable_sheet()->mutable_scene()->mutable_obj()->set_rest_shape(v1::REST_SHAPE_FLAT);
    start.mutable_start()->mutable_sheet()->set_sheet_id("large");
    start.mutable_start()->mutable_sheet()->set_paused(true);
    start.mutable_start()->set_num_bytes(static_cast<std::int64_t>(num_bytes));
    return start;
  }
  // A triangle, behind comments that make the file as long as is wanted.
  static std::string obj_of(std::size_t num_bytes) {
    const std::string mesh = "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::string file(num_bytes - mesh.size(), '#');
    for (std::size_t at = 1000; at < file.size(); at += 1000) file[at - 1] = '\n';
    return file + mesh;
  }
  // Sends the file in one chunk; OK with a sheet, or why not.
  grpc::Status upload_in_one(const std::string& file) {
    grpc::ClientContext context;
    v1::Sheet sheet;
    const auto writer = client_->sheets().UploadSheet(&context, &sheet);
    v1::UploadSheetRequest chunk;
    chunk.set_chunk(file);
    writer->Write(start_of(file.size()));
    writer->Write(chunk);
    writer->WritesDone();
    return writer->Finish();
  }

  // Until the server waits for something that is sent to it.
  void wait_for_timer() const {
    while (clock_.num_timers() == 0) std::this_thread::yield();
  }
  // Lets the time limit pass, and returns the client's error of its unfinished call.
  template <typename Writer>
  client::Failure after_30_s(Writer& writer) {
    wait_for_timer();
    clock_.move_to(clock_.now() + 30s);
    const grpc::Status status = writer.Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED) << status.error_message();
    return client::failure_of(status);
  }

  std::string address_;
  std::unique_ptr<rpc::RpcServer> server_;
  std::unique_ptr<client::Client> client_;
};

TEST_F(UploadTest, OneThatStandsStillIsEnded) {
  grpc::ClientContext context;
  v1::Sheet sheet;
  const auto writer = client_->sheets().UploadSheet(&context, &sheet);
  writer->Write(start_of(1000));
  const client::Failure failure = after_30_s(*writer);
  EXPECT_EQ(failure.reason, "UPLOAD_STALLED");
  EXPECT_NE(failure.message.find("for 30 s"), std::string::npos) << failure.message;
}

TEST_F(UploadTest, SoIsOneThatNeverBegins) {
  grpc::ClientContext context;
  v1::Sheet sheet;
  const auto writer = client_->sheets().ReplayRecording(&context, &sheet);
  EXPECT_EQ(after_30_s(*writer).reason, "UPLOAD_STALLED");
}

TEST_F(UploadTest, WhatIsSentWholeKeepsNoTimer) {
  grpc::ClientContext context;
  v1::Sheet sheet;
  const auto writer = client_->sheets().UploadSheet(&context, &sheet);
  v1::UploadSheetRequest chunk;
  chunk.set_chunk(obj_of(100));
  writer->Write(start_of(100));
  wait_for_timer();
  clock_.move_to(clock_.now() + 29s);
  writer->Write(chunk);
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(sheet.num_vertices(), 3);
  EXPECT_EQ(clock_.num_timers(), 0U);
}

TEST_F(UploadTest, MessagesThatBringNothingAreRefused) {
  for (const bool chosen : {true, false}) {
    grpc::ClientContext context;
    v1::Sheet sheet;
    const auto writer = client_->sheets().UploadSheet(&context, &sheet);
    v1::UploadSheetRequest empty;
    if (chosen) empty.set_chunk("");
    writer->Write(start_of(1000));
    writer->Write(empty);
    const grpc::Status status = writer->Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(client::failure_of(status).reason, chosen ? "CHUNK_EMPTY" : "CHOICE_MISSING");
    EXPECT_EQ(client::failure_of(status).field, chosen ? "chunk" : "kind");
  }
}

TEST_F(UploadTest, OneThatComesInSmallPartsIsEnded) {
  grpc::ClientContext context;
  v1::Sheet sheet;
  const auto writer = client_->sheets().UploadSheet(&context, &sheet);
  v1::UploadSheetRequest part;
  part.set_chunk(std::string(5000, '#'));  // large enough that few are under way: the clock is then close to the server
  bool open = writer->Write(start_of(std::size_t{64} << 20));
  wait_for_timer();
  while (open) {
    open = writer->Write(part);
    clock_.move_to(clock_.now() + 10ms);
  }
  EXPECT_EQ(client::failure_of(writer->Finish()).reason, "UPLOAD_TOO_SLOW");
}

TEST_F(UploadTest, AChunkFillsAMessage) {
  constexpr std::size_t kMostBytes = (std::size_t{1} << 20) - 4;
  const grpc::Status most = upload_in_one(obj_of(kMostBytes));
  EXPECT_TRUE(most.ok()) << most.error_message();
  EXPECT_EQ(upload_in_one(obj_of(kMostBytes + 1)).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_LE(client::kUploadChunkBytes, kMostBytes);
}

TEST_F(UploadTest, AReaderThatTakesNothingOfARecordingIsCutOff) {
  ASSERT_TRUE(upload_in_one(obj_of(1'000'000)).ok());
  v1::GetSheetRecordingRequest request;
  request.set_name("sheets/large");
  // Keeps windows from growing: a chunk is larger than they are.
  grpc::ChannelArguments narrow;
  narrow.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  narrow.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  client::Client client(grpc::CreateCustomChannel(address_, grpc::InsecureChannelCredentials(), narrow));
  grpc::ClientContext context;
  const auto reader = client.sheets().GetSheetRecording(&context, request);
  wait_for_timer();
  while (clock_.num_timers() > 0) clock_.move_to(clock_.now() + 30s);
  v1::RecordingChunk chunk;
  std::size_t read = 0;
  while (reader->Read(&chunk)) read += chunk.content().size();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_LT(read, 1'000'000U);
}

}  // namespace
}  // namespace kerf::rpc_test
