#include <gtest/gtest.h>

#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/security/credentials.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "server/service/api/api.h"
#include "server/service/host/clock.h"
#include "server/service/host/entropy.h"
#include "server/service/host/host.h"
#include "server/service/rpc/grpc_status.h"
#include "server/service/rpc/messages.h"
#include "server/service/rpc/rpc_server.h"
#include "tests/rpc/fixture.h"
#include "tests/support/wait_until.h"

namespace kerf::rpc_test {
namespace {

using client::Failure;
using grpc::StatusCode;

grpc::ByteBuffer to_buffer(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return {&slice, 1};
}

std::string to_string(const grpc::ByteBuffer& buffer) {
  grpc::Slice slice;
  return buffer.DumpToSingleSlice(&slice).ok() ? std::string(slice.begin(), slice.end()) : std::string();
}

// One message there, one back, of any method, without generated code.
grpc::Status exchange(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                      const std::string& request, std::string& response) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
  grpc::CompletionQueue queue;
  const std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call = stub.PrepareCall(&context, method, &queue);
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  grpc::ByteBuffer received;
  grpc::Status status;
  call->StartCall(nullptr);
  wait();
  call->WriteLast(to_buffer(request), grpc::WriteOptions(), nullptr);
  wait();
  call->Read(&received, nullptr);
  if (wait()) response = to_string(received);
  call->Finish(&status, nullptr);
  wait();
  return status;
}

// grpc.health.v1.HealthCheckResponse.status; -1 if the call failed.
int health_of(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  std::string request;
  if (!service.empty()) request = std::string("\x0a") + static_cast<char>(service.size()) + service;
  std::string response;
  const grpc::Status status = exchange(channel, "/grpc.health.v1.Health/Check", request, response);
  if (!status.ok() || response.size() != 2 || response[0] != 0x08) return -1;
  return response[1];
}
constexpr int kServing = 1;
constexpr int kNotServing = 2;

TEST_F(RpcServerTest, AnswersEveryService) {
  const v1::Sheet sheet = create("a");
  EXPECT_EQ(sheet.name(), "sheets/a");
  EXPECT_EQ(sheet.num_vertices(), 64);
  EXPECT_EQ(sheet.run_state(), v1::Sheet::PAUSED);

  v1::CreateCutRequest cut;
  cut.set_parent("sheets/a");
  v1::Circle& circle = *cut.mutable_cut()->mutable_curve()->mutable_circle();
  circle.mutable_center()->set_x(0.5);
  circle.mutable_center()->set_y(0.5);
  circle.set_radius_m(0.2);
  v1::CutResult result;
  grpc::Status status = client_->call(&v1::CutService::Stub::CreateCut, client_->cuts(), cut, result);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(result.status(), v1::CutResult::APPLIED);
  EXPECT_EQ(result.pieces(), 2);
  EXPECT_EQ(result.state_hash(), get("sheets/a").state_hash());

  v1::SetSheetGravityRequest gravity;
  gravity.set_name("sheets/a");
  gravity.mutable_set_gravity()->mutable_gravity_mps2()->set_z(-1.0);
  v1::InteractionResponse done;
  status = client_->call(&v1::InteractionService::Stub::SetSheetGravity, client_->interaction(), gravity, done);
  EXPECT_TRUE(status.ok()) << status.error_message();

  v1::ServerInfo info;
  status = client_->call(&v1::ServerService::Stub::GetServerInfo, client_->server(), v1::GetServerInfoRequest(), info);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(info.num_sheets(), 1);
  EXPECT_EQ(info.workers(), 2);

  v1::RenderImageRequest picture;
  picture.set_name("sheets/a");
  v1::RenderImageResponse image;
  status = client_->call(&v1::RenderService::Stub::RenderImage, client_->render(), picture, image);
  EXPECT_EQ(status.error_code(), StatusCode::UNAVAILABLE) << "the test's server has no renderer";
}

TEST_F(RpcServerTest, RefusalsCarryReasonAndField) {
  const v1::Sheet before = create("a");
  v1::CreateCutRequest cut;
  cut.set_parent("sheets/a");
  v1::CubicBezier& curve = *cut.mutable_cut()->mutable_curve()->mutable_bezier();
  for (int i = 0; i < 4; ++i) curve.add_points()->set_x(0.1 * i);
  curve.mutable_points(2)->set_y(std::numeric_limits<double>::quiet_NaN());
  v1::CutResult result;
  const grpc::Status status = client_->call(&v1::CutService::Stub::CreateCut, client_->cuts(), cut, result);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  const Failure failure = client::failure_of(status);
  EXPECT_EQ(failure.field, "cut.curve.bezier.points[2].y");
  EXPECT_FALSE(failure.reason.empty());
  EXPECT_EQ(failure.message, status.error_message());
  EXPECT_EQ(get("sheets/a").state_hash(), before.state_hash());

  cut.set_parent("sheets/none");
  curve.mutable_points(2)->set_y(0.0);
  const grpc::Status missing = client_->call(&v1::CutService::Stub::CreateCut, client_->cuts(), cut, result);
  EXPECT_EQ(missing.error_code(), StatusCode::NOT_FOUND);
  EXPECT_EQ(client::failure_of(missing).reason, "SHEET_NOT_FOUND");
  EXPECT_EQ(client::failure_of(missing).field, "parent");
}

TEST_F(RpcServerTest, BytesThatAreNoMessageAreRefused) {
  const auto channel = grpc::CreateChannel(server_->grpc_address(), grpc::InsecureChannelCredentials());
  const std::string truncated = "\x0a\x7f";  // field 1, of 127 bytes that do not come
  for (const auto& [service, methods] : std::map<std::string, std::vector<std::string>>{
           {"SheetService",
            {"CreateSheet", "GetSheet", "ListSheets", "DeleteSheet", "PauseSheet", "ResumeSheet", "StepSheet",
             "StepSheets", "ResetSheet", "SetSheetSpeed", "ExportSheet", "GetSheetState", "AnalyzeSheet", "SaveState",
             "RestoreState", "ListStates", "DeleteState"}},
           {"CutService",
            {"CreateCut", "CreateCuts", "ListCuts", "CancelScheduledCuts", "UndoCut", "RedoCut", "ListPieces"}},
           {"InteractionService",
            {"GrabPoint", "DragPoint", "ReleasePoint", "SetSheetPins", "SetSheetGravity", "SetSheetWind",
             "SetSheetMaterial", "SetSheetSelfContact"}},
           {"FileService", {"InspectMesh", "InspectDrawing"}},
           {"StreamService", {"Watch"}},
           {"RenderService", {"RenderImage"}},
           {"ServerService", {"GetServerInfo"}},
           {"StoreService", {"GetStoreInfo", "PruneStore", "DeleteSetAsideSheet", "BackupStore"}}}) {
    for (const std::string& method : methods) {
      std::string response;
      const grpc::Status status = exchange(channel, "/kerf.v1." + service + "/" + method, truncated, response);
      EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT) << method;
      EXPECT_EQ(client::failure_of(status).reason, "MALFORMED_MESSAGE") << method;
    }
  }
}

TEST_F(RpcServerTest, SizeIsJudgedBeforeContent) {
  const auto channel = grpc::CreateChannel(server_->grpc_address(), grpc::InsecureChannelCredentials());
  const std::size_t limit = std::size_t{1} << 20;
  for (const char* method : {"CutService/CreateCut", "SheetService/StepSheet", "StreamService/Watch"}) {
    std::string response;
    const std::string path = std::string("/kerf.v1.") + method;
    EXPECT_EQ(exchange(channel, path, std::string(limit, '\xff'), response).error_code(), StatusCode::INVALID_ARGUMENT);
    for (const std::size_t bytes : {limit + 1, 2 * limit}) {
      EXPECT_EQ(exchange(channel, path, std::string(bytes, '\xff'), response).error_code(),
                StatusCode::RESOURCE_EXHAUSTED)
          << method << ", " << bytes;
    }
  }
  const Result<v1::GetSheetRequest> none = rpc::parse_message<v1::GetSheetRequest>(grpc::ByteBuffer());
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().reason, "MESSAGE_INCOMPLETE");
}

TEST_F(RpcServerTest, NumbersThatAreNotFiniteAreRefusedWhereNothingReadsThem) {
  create("a");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  v1::CreateCutRequest cut;
  cut.set_parent("sheets/a");
  cut.mutable_cut()->mutable_curve()->mutable_circle()->set_radius_m(0.1);
  cut.mutable_cut()->mutable_view()->set_farthest_m(nan);
  v1::CutResult result;
  const grpc::Status refused = client_->call(&v1::CutService::Stub::CreateCut, client_->cuts(), cut, result);
  EXPECT_EQ(refused.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(client::failure_of(refused).field, "cut.view.farthest_m");
  v1::CreateCutsRequest batch;
  batch.set_parent("sheets/a");
  *batch.add_cuts() = cut.cut();
  v1::CreateCutsResponse results;
  const grpc::Status refused_batch = client_->call(&v1::CutService::Stub::CreateCuts, client_->cuts(), batch, results);
  EXPECT_EQ(refused_batch.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(client::failure_of(refused_batch).field, "cuts[0].view.farthest_m");
}

TEST_F(RpcServerTest, RequestsEndAtTheLimit) {
  v1::CreateSheetRequest request;
  request.mutable_scene()->mutable_obj()->set_text(std::string((1 << 20) + 1, '#'));
  v1::Sheet sheet;
  const grpc::Status status = client_->call(&v1::SheetService::Stub::CreateSheet, client_->sheets(), request, sheet);
  EXPECT_EQ(status.error_code(), StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
  // One byte less than what gRPC would refuse reaches the Api, which does not like it as a mesh.
  v1::CreateSheetRequest fitting = request;
  std::string& text = *fitting.mutable_scene()->mutable_obj()->mutable_text();
  text.resize(text.size() - (request.ByteSizeLong() - (1 << 20)));
  ASSERT_EQ(fitting.ByteSizeLong(), 1U << 20);
  EXPECT_EQ(client_->call(&v1::SheetService::Stub::CreateSheet, client_->sheets(), fitting, sheet).error_code(),
            StatusCode::INVALID_ARGUMENT);
}

TEST_F(RpcServerTest, ReflectionListsTheServices) {
  const auto channel = grpc::CreateChannel(server_->grpc_address(), grpc::InsecureChannelCredentials());
  std::string response;
  // ServerReflectionRequest.list_services (7) = "".
  const grpc::Status status = exchange(channel, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                                       std::string("\x3a\x00", 2), response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  for (const char* name : {"kerf.v1.SheetService", "kerf.v1.CutService", "kerf.v1.FileService",
                           "kerf.v1.InteractionService", "kerf.v1.StreamService", "kerf.v1.RenderService",
                           "kerf.v1.ServerService", "kerf.v1.StoreService", "grpc.health.v1.Health"}) {
    EXPECT_NE(response.find(name), std::string::npos) << name;
  }
}

TEST_F(RpcServerTest, NeverSharesAPort) {
  app::Config config = ws_test::test_config();
  config.grpc.port = ws_test::port_of(server_->grpc_address());
  const auto second = app::Server::start(config, [](std::string_view) {});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().reason, "ADDRESS_IN_USE");
  EXPECT_NE(second.error().message.find(server_->grpc_address()), std::string::npos) << second.error().message;
  create("still-here");
}

TEST_F(RpcServerTest, ACancelledStepEnds) {
  create("a");
  constexpr std::int32_t kManyTicks = 100'000;
  v1::StepSheetRequest request;
  request.set_name("sheets/a");
  request.set_ticks(kManyTicks);
  grpc::ClientContext context;
  std::thread caller([&] {
    v1::Sheet sheet;
    EXPECT_EQ(client_->sheets().StepSheet(&context, request, &sheet).error_code(), StatusCode::CANCELLED);
  });
  test::wait_until([&] { return get("sheets/a").tick() != 0; });
  context.TryCancel();
  caller.join();
  // Refused while the first call runs.
  request.set_ticks(1);
  v1::Sheet stepped;
  grpc::Status status;
  do {
    status = client_->call(&v1::SheetService::Stub::StepSheet, client_->sheets(), request, stepped);
  } while (status.error_code() == StatusCode::FAILED_PRECONDITION);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_LT(stepped.tick(), kManyTicks);
}

// The one behind it would wait in vain: 100,000 ticks of this sheet take minutes.
TEST_F(RpcServerTest, ADynamicAnalysisEndsAtItsDeadline) {
  v1::CreateSheetRequest made;
  made.set_sheet_id("heavy");
  made.set_paused(true);
  v1::GridMesh& grid = *made.mutable_scene()->mutable_grid();
  grid.set_columns(60);
  grid.set_rows(60);
  grid.set_width_m(1.0);
  grid.set_height_m(1.0);
  v1::Sheet heavy;
  ASSERT_TRUE(client_->call(&v1::SheetService::Stub::CreateSheet, client_->sheets(), made, heavy).ok());
  v1::AnalyzeSheetRequest request;
  request.set_name("sheets/heavy");
  request.mutable_analysis()->mutable_dynamic()->set_ticks(100'000);
  v1::AnalyzeSheetResponse response;
  EXPECT_EQ(client_
                ->call(&v1::SheetService::Stub::AnalyzeSheet, client_->sheets(), request, response,
                       std::chrono::milliseconds(200))
                .error_code(),
            StatusCode::DEADLINE_EXCEEDED);
  request.mutable_analysis()->mutable_dynamic()->set_ticks(2);
  const grpc::Status second = client_->call(&v1::SheetService::Stub::AnalyzeSheet, client_->sheets(), request, response,
                                            std::chrono::seconds(20));
  ASSERT_TRUE(second.ok()) << second.error_message();
  EXPECT_EQ(response.dynamic().ticks(), 2);
  EXPECT_EQ(get("sheets/heavy").state_hash(), heavy.state_hash());
}

TEST_F(RpcServerTest, StopAnswersWhatIsUnderWay) {
  create("a");
  v1::StepSheetRequest request;
  request.set_name("sheets/a");
  request.set_ticks(100'000);
  std::atomic<bool> answered{false};
  std::thread caller([&] {
    v1::Sheet sheet;
    const grpc::Status status = client_->call(&v1::SheetService::Stub::StepSheet, client_->sheets(), request, sheet);
    // Which of the two depends on who comes first: the stop, or a very fast machine.
    EXPECT_TRUE(status.ok() || status.error_code() == StatusCode::UNAVAILABLE) << status.error_message();
    answered = true;
  });
  // Under way once a tick is done. A call that gRPC has only just received when the server goes is cancelled by gRPC.
  v1::GetSheetRequest get;
  get.set_name("sheets/a");
  v1::Sheet sheet;
  while (!answered && sheet.tick() == 0) {
    ASSERT_TRUE(client_->call(&v1::SheetService::Stub::GetSheet, client_->sheets(), get, sheet).ok());
  }
  server_->stop();
  caller.join();
  v1::ServerInfo info;
  EXPECT_EQ(client_->call(&v1::ServerService::Stub::GetServerInfo, client_->server(), v1::GetServerInfoRequest(), info)
                .error_code(),
            StatusCode::UNAVAILABLE);
}

TEST(RpcServer, HealthFollowsTheDrain) {
  host::RealClock clock;
  host::SeededEntropy entropy(1);
  host::Host host({}, clock, entropy);
  api::Api api(host, nullptr, {}, clock);
  rpc::RpcServer server(api, clock);
  const Result<int> port = server.start("127.0.0.1:0");
  ASSERT_TRUE(port.ok());
  const auto channel = grpc::CreateChannel("127.0.0.1:" + std::to_string(*port), grpc::InsecureChannelCredentials());
  EXPECT_EQ(health_of(channel, ""), kServing);
  EXPECT_EQ(health_of(channel, "kerf.v1.CutService"), kServing);
  EXPECT_EQ(health_of(channel, "kerf.v1.NoService"), -1);
  server.drain();
  EXPECT_EQ(health_of(channel, ""), kNotServing);
  EXPECT_EQ(health_of(channel, "kerf.v1.CutService"), kNotServing);
  client::Client client(channel);
  v1::ServerInfo info;
  EXPECT_TRUE(
      client.call(&v1::ServerService::Stub::GetServerInfo, client.server(), v1::GetServerInfoRequest(), info).ok())
      << "draining, it still answers";
  server.stop(std::chrono::seconds(1));
  server.stop(std::chrono::seconds(1));
  EXPECT_EQ(health_of(channel, ""), -1);
}

TEST(GrpcStatus, FitsIntoATrailer) {
  Error error = invalid_argument("TOO_LONG", std::string(20'000, 'm'), std::string(20'000, 'f'));
  const grpc::Status status = rpc::to_status(error);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  // Base64 adds a third; a client takes 8 KiB by default.
  EXPECT_LT(status.error_message().size() + status.error_details().size() * 4 / 3, 6000U);
  EXPECT_EQ(client::failure_of(status).reason, "TOO_LONG");
  error.message = "short";
  error.field = "grid.columns";
  const Failure failure = client::failure_of(rpc::to_status(error));
  EXPECT_EQ(failure.message, "short");
  EXPECT_EQ(failure.field, "grid.columns");
}

}  // namespace
}  // namespace kerf::rpc_test
