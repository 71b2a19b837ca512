#pragma once

#include <chrono>
#include <string>

#include "client/cpp/client.h"
#include "client/cpp/result.h"

namespace kerf::client {

// Wraps a Client so that calls return a Result. Thread-safe.
class Connection {
 public:
  // Throws CallFailed as Client does.
  Connection(const std::string& address, const Credentials& credentials, std::chrono::milliseconds timeout)
      : client_(address, credentials), timeout_(timeout) {}

  // Makes one unary call: connection.call(&v1::CutService::Stub::CreateCut, connection.client().cuts(), request)
  template <typename Service, typename Request, typename Response>
  Result<Response> call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                        Service& service, const Request& request) {
    Response response;
    const grpc::Status status = client_.call(method, service, request, response, timeout_);
    if (!status.ok()) return failure_of(status);
    return response;
  }

  [[nodiscard]] std::chrono::milliseconds timeout() const { return timeout_; }
  [[nodiscard]] Client& client() { return client_; }

 private:
  Client client_;
  std::chrono::milliseconds timeout_;
};

}  // namespace kerf::client
