#include "client/cpp/client.h"

#include <utility>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

namespace kerf::client {
namespace {

std::shared_ptr<grpc::Channel> open_channel(const std::string& address, Client::Connection connection) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(Client::kMaxReceiveBytes);
  // Ignores proxies set in the environment: Kerf servers are near, and a buffering proxy would spoil the stream.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);  // Finds a restarted server soon.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, connection == Client::Connection::kOwn ? 1 : 0);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

Client::Client(const std::string& address, Connection connection) : Client(open_channel(address, connection)) {}

Client::Client(std::shared_ptr<grpc::Channel> channel)
    : channel_(std::move(channel)),
      sheets_(v1::SheetService::NewStub(channel_)),
      cuts_(v1::CutService::NewStub(channel_)),
      interaction_(v1::InteractionService::NewStub(channel_)),
      stream_(v1::StreamService::NewStub(channel_)),
      render_(v1::RenderService::NewStub(channel_)),
      server_(v1::ServerService::NewStub(channel_)),
      store_(v1::StoreService::NewStub(channel_)) {}

}  // namespace kerf::client
