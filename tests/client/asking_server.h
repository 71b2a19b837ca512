#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include "kerf/v1/access_service.grpc.pb.h"
#include "server/base/result.h"
#include "server/service/wire/error_codec.h"

namespace kerf::client_test {

// A server that notes which calls come, and with which token. It answers those of AccessService; all others are
// UNIMPLEMENTED.
class AskingServer {
 public:
  explicit AskingServer(const std::shared_ptr<grpc::ServerCredentials>& credentials = grpc::InsecureServerCredentials())
      : access_(*this), others_(*this) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", credentials, &port_);
    builder.RegisterService(&access_);
    builder.RegisterCallbackGenericService(&others_);
    server_ = builder.BuildAndStart();
    EXPECT_NE(server_, nullptr);
  }
  ~AskingServer() { server_->Shutdown(std::chrono::system_clock::now()); }
  AskingServer(const AskingServer&) = delete;
  AskingServer& operator=(const AskingServer&) = delete;

  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // The values of `authorization` of each call, by method: "/kerf.v1.CutService/CreateCut".
  [[nodiscard]] std::map<std::string, std::vector<std::string>> calls() const {
    const std::lock_guard lock(mutex_);
    return calls_;
  }

  v1::Access access;                   // The answer of GetAccess.
  v1::CreateLinkRequest link_request;  // The last one.
  std::optional<Error> refusal;        // Ends both calls of AccessService.

 private:
  void note(const std::string& method, const grpc::ServerContextBase& context) {
    const std::lock_guard lock(mutex_);
    std::vector<std::string>& values = calls_[method];
    const auto [begin, end] = context.client_metadata().equal_range("authorization");
    for (auto at = begin; at != end; ++at) values.emplace_back(at->second.data(), at->second.size());
  }

  [[nodiscard]] grpc::Status status() const {
    if (!refusal) return grpc::Status::OK;
    return {static_cast<grpc::StatusCode>(wire::status_code(refusal->code)), refusal->message,
            wire::encode_status(*refusal)};
  }

  class Access : public v1::AccessService::Service {
   public:
    explicit Access(AskingServer& server) : server_(server) {}
    grpc::Status GetAccess(grpc::ServerContext* context, const v1::GetAccessRequest* /*request*/,
                           v1::Access* reply) override {
      server_.note("/kerf.v1.AccessService/GetAccess", *context);
      *reply = server_.access;
      return server_.status();
    }
    grpc::Status CreateLink(grpc::ServerContext* context, const v1::CreateLinkRequest* request,
                            v1::AccessLink* reply) override {
      server_.note("/kerf.v1.AccessService/CreateLink", *context);
      server_.link_request = *request;
      reply->set_path("/?sheet=" + request->sheet_id() + "#code=abc");
      reply->set_expires_unix_s(1'800'000'000);
      return server_.status();
    }

   private:
    AskingServer& server_;
  };

  class Others : public grpc::CallbackGenericService {
   public:
    explicit Others(AskingServer& server) : server_(server) {}
    grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext* context) override {
      class Refusing : public grpc::ServerGenericBidiReactor {
       public:
        Refusing() { Finish({grpc::StatusCode::UNIMPLEMENTED, "of a test"}); }
        void OnDone() override { delete this; }
      };
      server_.note(context->method(), *context);
      return new Refusing;
    }

   private:
    AskingServer& server_;
  };

  mutable std::mutex mutex_;
  std::map<std::string, std::vector<std::string>> calls_;  // Guarded by mutex_.
  Access access_;
  Others others_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace kerf::client_test
