#pragma once

#include <grpcpp/impl/codegen/service_type.h>

#include <memory>
#include <string>
#include <vector>

#include "server/service/rpc/transfers.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::rpc {

struct NamedService {
  std::string name;  // "kerf.v1.CutService"
  std::unique_ptr<grpc::Service> service;
};

struct StreamHosting;

// Returns every service of kerf.v1 over `api`. `api`, the clock and `hosting` must outlive them.
std::vector<NamedService> make_services(api::Api& api, TransferTiming timing, StreamHosting& hosting);

// Returns StreamService. Its messages pass through as bytes, so that a frame is serialised once for all streams.
std::unique_ptr<grpc::Service> make_stream_service(api::Api& api, StreamHosting& hosting);

}  // namespace kerf::rpc
