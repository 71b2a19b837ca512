// Files that are larger than a message: uploads, and recordings.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/cpp/failure.h"
#include "client/cpp/transfers.h"
#include "server/core/sheet/recording.h"
#include "server/service/wire/recording_codec.h"
#include "tests/rpc/fixture.h"

namespace kerf::rpc_test {
namespace {

using grpc::StatusCode;

// Creates sheets/large, paused.
v1::CreateSheetRequest of_a_mesh_file() {
  v1::CreateSheetRequest request;
  request.set_sheet_id("large");
  request.set_paused(true);
  request.mutable_scene()->mutable_obj()->set_rest_shape(v1::REST_SHAPE_FLAT);
  return request;
}

TEST_F(RpcServerTest, AMeshFileComesInParts) {
  std::string file = "# " + std::string(std::size_t{2} << 20, 'x').insert(1 << 10, "\n# ") + "\n";
  for (std::size_t at = 4000; at < file.size() - 4; at += 4000) file.replace(at, 3, "\n# ");
  file += "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  v1::CreateSheetRequest request = of_a_mesh_file();
  v1::Sheet sheet;
  const grpc::Status made = client::upload_sheet(*client_, request, file, sheet);
  ASSERT_TRUE(made.ok()) << made.error_message();
  EXPECT_EQ(sheet.name(), "sheets/large");
  EXPECT_EQ(sheet.num_vertices(), 3);

  request.mutable_scene()->mutable_grid()->set_columns(5);
  const grpc::Status what = client::upload_sheet(*client_, request, file, sheet);
  EXPECT_EQ(what.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(client::failure_of(what).field, "start.sheet.scene");
}

TEST_F(RpcServerTest, ARecordingOfManyChunksIsFetchedWhole) {
  std::string file;
  for (int i = 0; i < 60'000; ++i) file += "# of what, in line " + std::to_string(i) + "\n";
  file += "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  v1::Sheet sheet;
  ASSERT_TRUE(client::upload_sheet(*client_, of_a_mesh_file(), file, sheet).ok());
  std::string bytes;
  const grpc::Status fetched = client::fetch_recording(*client_, "sheets/large", bytes);
  ASSERT_TRUE(fetched.ok()) << fetched.error_message();
  ASSERT_GT(bytes.size(), std::size_t{10} << 16) << "chunks of 64 KiB";
  const Result<wire::RecordingFile> recording = wire::decode_recording(bytes);
  ASSERT_TRUE(recording.ok()) << recording.error().message;
  EXPECT_EQ(std::get<scene::ObjSource>(recording->recording.config.mesh).text, file);
}

TEST_F(RpcServerTest, UploadsAreRefusedByTheirFirstMessage) {
  const auto status_of = [this](const std::vector<v1::UploadSheetRequest>& messages) {
    grpc::ClientContext context;
    v1::Sheet sheet;
    const auto writer = client_->sheets().UploadSheet(&context, &sheet);
    for (const v1::UploadSheetRequest& message : messages) writer->Write(message);
    writer->WritesDone();
    return client::failure_of(writer->Finish());
  };
  v1::UploadSheetRequest start, chunk;
  start.mutable_start()->mutable_sheet()->mutable_scene()->mutable_obj();
  chunk.set_chunk("v 0 0 0\n");
  EXPECT_EQ(status_of({}).reason, "UPLOAD_ORDER");
  EXPECT_EQ(status_of({chunk}).reason, "UPLOAD_ORDER");
  EXPECT_EQ(status_of({start}).field, "start.num_bytes");
  start.mutable_start()->set_num_bytes((64 << 20) + 1);
  EXPECT_EQ(status_of({start}).field, "start.num_bytes");
  start.mutable_start()->set_num_bytes(16);
  EXPECT_EQ(status_of({start, chunk}).reason, "UPLOAD_LENGTH") << "too few";
  EXPECT_EQ(status_of({start, chunk, chunk, chunk}).reason, "UPLOAD_LENGTH") << "too many";
  EXPECT_EQ(status_of({start, start}).reason, "UPLOAD_ORDER");
}

TEST_F(RpcServerTest, ARecordingIsFetchedAndPlayed) {
  v1::CreateSheetRequest request;
  request.set_sheet_id("live");
  request.set_paused(true);
  request.mutable_scene()->mutable_grid()->set_columns(9);
  request.mutable_scene()->mutable_grid()->set_rows(9);
  request.mutable_scene()->mutable_grid()->set_width_m(1.0);
  request.mutable_scene()->mutable_grid()->set_height_m(1.0);
  v1::Sheet live;
  ASSERT_TRUE(client_->call(&v1::SheetService::Stub::CreateSheet, client_->sheets(), request, live).ok());
  v1::StepSheetRequest step;
  step.set_name("sheets/live");
  step.set_ticks(70);
  ASSERT_TRUE(client_->call(&v1::SheetService::Stub::StepSheet, client_->sheets(), step, live).ok());
  v1::SetSheetMaterialRequest material;
  material.set_name("sheets/live");
  material.mutable_set_material()->mutable_material()->set_preset("silk");
  v1::InteractionResponse set;
  ASSERT_TRUE(
      client_->call(&v1::InteractionService::Stub::SetSheetMaterial, client_->interaction(), material, set).ok());
  step.set_ticks(10);
  ASSERT_TRUE(client_->call(&v1::SheetService::Stub::StepSheet, client_->sheets(), step, live).ok());

  std::string file;
  ASSERT_TRUE(client::fetch_recording(*client_, "sheets/live", file).ok());
  const Result<wire::RecordingFile> recording = wire::decode_recording(file);
  ASSERT_TRUE(recording.ok()) << recording.error().message;
  const Result<sheet::ReplayReport> report = sheet::replay(recording->recording);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence);
  EXPECT_EQ(report->ticks, 80);

  v1::Sheet played;
  ASSERT_TRUE(client::replay_recording(*client_, "played", true, file, played).ok());
  EXPECT_EQ(played.replay().state(), v1::Replay::PLAYING);
  EXPECT_EQ(played.replay().end_tick(), 80);
  step.set_name("sheets/played");
  step.set_ticks(1000);
  ASSERT_TRUE(client_->call(&v1::SheetService::Stub::StepSheet, client_->sheets(), step, played).ok());
  EXPECT_EQ(played.replay().state(), v1::Replay::DONE);
  EXPECT_EQ(played.state_hash(), live.state_hash());

  ASSERT_TRUE(client::replay_recording(*client_, "torn", true, file.substr(0, file.size() - 1), played).ok());
  EXPECT_GT(played.replay().torn_bytes(), 0);
  std::string flipped = file;
  flipped[flipped.size() / 2] ^= 1;
  const grpc::Status damaged = client::replay_recording(*client_, "bad", true, flipped, played);
  EXPECT_EQ(damaged.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(client::failure_of(damaged).reason, "RECORDING_DAMAGED");
  EXPECT_EQ(client::fetch_recording(*client_, "sheets/nobody", file).error_code(), StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace kerf::rpc_test
