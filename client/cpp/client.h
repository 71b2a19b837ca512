#pragma once

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include "client/cpp/failure.h"
#include "kerf/v1/cuts.grpc.pb.h"
#include "kerf/v1/interaction.grpc.pb.h"
#include "kerf/v1/render.grpc.pb.h"
#include "kerf/v1/server.grpc.pb.h"
#include "kerf/v1/sheets.grpc.pb.h"
#include "kerf/v1/store_service.grpc.pb.h"
#include "kerf/v1/stream.grpc.pb.h"

namespace kerf::client {

// Connects to one Kerf server, with the typed stubs of all services. Connecting is lazy: an unreachable server gives
// UNAVAILABLE at the first call. Thread-safe, as gRPC stubs are.
class Client {
 public:
  // Largest message that a client accepts. The OBJ file of a sheet with 500,000 vertices has some 90 MB.
  static constexpr int kMaxReceiveBytes = 256 << 20;

  // kShared: all clients of a process with the same address share a connection. kOwn: the client has a connection of
  // its own, as if on another machine.
  enum class Connection { kShared, kOwn };

  // `address`: "HOST:PORT".
  explicit Client(const std::string& address, Connection connection = Connection::kShared);
  explicit Client(std::shared_ptr<grpc::Channel> channel);

  // Makes one unary call with a deadline:
  //   client.call(&v1::CutService::Stub::CreateCut, client.cuts(), request, response)
  template <typename Service, typename Request, typename Response>
  grpc::Status call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*), Service& service,
                    const Request& request, Response& response,
                    std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + timeout);
    return (service.*method)(&context, request, &response);
  }

  // Connects now. Returns false if that takes longer than `timeout`.
  bool wait_until_connected(std::chrono::milliseconds timeout) {
    return channel_->WaitForConnected(std::chrono::system_clock::now() + timeout);
  }

  [[nodiscard]] v1::SheetService::Stub& sheets() { return *sheets_; }
  [[nodiscard]] v1::CutService::Stub& cuts() { return *cuts_; }
  [[nodiscard]] v1::InteractionService::Stub& interaction() { return *interaction_; }
  [[nodiscard]] v1::StreamService::Stub& stream() { return *stream_; }
  [[nodiscard]] v1::RenderService::Stub& render() { return *render_; }
  [[nodiscard]] v1::ServerService::Stub& server() { return *server_; }
  [[nodiscard]] v1::StoreService::Stub& store() { return *store_; }

 private:
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SheetService::Stub> sheets_;
  std::unique_ptr<v1::CutService::Stub> cuts_;
  std::unique_ptr<v1::InteractionService::Stub> interaction_;
  std::unique_ptr<v1::StreamService::Stub> stream_;
  std::unique_ptr<v1::RenderService::Stub> render_;
  std::unique_ptr<v1::ServerService::Stub> server_;
  std::unique_ptr<v1::StoreService::Stub> store_;
};

}  // namespace kerf::client
