#pragma once

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include "client/cpp/failure.h"
#include "client/cpp/result.h"
#include "kerf/v1/access_service.grpc.pb.h"
#include "kerf/v1/cuts.grpc.pb.h"
#include "kerf/v1/interaction.grpc.pb.h"
#include "kerf/v1/render.grpc.pb.h"
#include "kerf/v1/server.grpc.pb.h"
#include "kerf/v1/sheets.grpc.pb.h"
#include "kerf/v1/store_service.grpc.pb.h"
#include "kerf/v1/stream.grpc.pb.h"

namespace kerf::client {

// Says who calls, and how calls are encrypted. Files are read when a Client is made. Without any of it calls carry no
// token and are not encrypted. A token is sent without TLS only to 127.0.0.0/8, ::1, localhost and unix sockets.
struct Credentials {
  std::string token = {};       // Printable ASCII; white space around it is dropped. Empty: none, or that of the file.
  std::string token_file = {};  // Path of a file with one line, the token.
  bool use_tls = false;         // True also if one of the next two is given.
  std::string tls_ca = {};      // Path of a PEM file: the authorities to trust. Empty: those of the system.
  std::string tls_cert = {};    // Path of a PEM file: the certificate to show, with those between it and its authority.
  std::string tls_key = {};     // Path of a PEM file: its key, without a password.
  std::string tls_name = {};    // Name in the server's certificate; empty: the host of the address. A tunnel needs it.
};

// Connects to one Kerf server, with the typed stubs of all services. Connecting is lazy: an unreachable server gives
// UNAVAILABLE at the first call. Thread-safe, as gRPC stubs are.
class Client {
 public:
  // Largest message that a client accepts. The OBJ file of a sheet with 500,000 vertices has some 90 MB.
  static constexpr int kMaxReceiveBytes = 256 << 20;

  // kShared: all clients of a process with the same address share a connection, unless it is encrypted. kOwn: the
  // client has a connection of its own, as if on another machine.
  enum class Connection { kShared, kOwn };

  // `address`: "HOST:PORT". Throws CallFailed if the credentials cannot be used: INVALID_ARGUMENT with the member at
  // fault as its field, such as CREDENTIALS_UNREADABLE, TLS_PAIR_INCOMPLETE or TOKEN_NEEDS_TLS.
  explicit Client(const std::string& address, const Credentials& credentials = {},
                  Connection connection = Connection::kShared);
  explicit Client(std::shared_ptr<grpc::Channel> channel);

  // Makes one unary call with a deadline:
  //   client.call(&v1::CutService::Stub::CreateCut, client.cuts(), request, response)
  template <typename Service, typename Request, typename Response>
  grpc::Status call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*), Service& service,
                    const Request& request, Response& response,
                    std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + timeout);
    grpc::Status status = (service.*method)(&context, request, &response);
    if (status.error_code() == grpc::StatusCode::UNAVAILABLE) wait_until_connected(kLooksFor);
    return status;
  }

  // Connects now. Returns false if that takes longer than `timeout`. It also waits for a server that was lost: without
  // a call in progress gRPC looks only every 5 s whether it has connected.
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
  [[nodiscard]] v1::AccessService::Stub& access() { return *access_; }

 private:
  // Time that a call looks for a lost server before it fails, so that the next call finds one that is back.
  static constexpr std::chrono::milliseconds kLooksFor{100};

  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SheetService::Stub> sheets_;
  std::unique_ptr<v1::CutService::Stub> cuts_;
  std::unique_ptr<v1::InteractionService::Stub> interaction_;
  std::unique_ptr<v1::StreamService::Stub> stream_;
  std::unique_ptr<v1::RenderService::Stub> render_;
  std::unique_ptr<v1::ServerService::Stub> server_;
  std::unique_ptr<v1::StoreService::Stub> store_;
  std::unique_ptr<v1::AccessService::Stub> access_;
};

}  // namespace kerf::client
