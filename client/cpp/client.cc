#include "client/cpp/client.h"

#include <utility>

#include "client/cpp/credentials.h"

namespace kerf::client {

Client::Client(const std::string& address, const Credentials& credentials, Connection connection)
    : Client(open_channel(address, read_secrets(credentials, address).value(), connection)) {}

Client::Client(std::shared_ptr<grpc::Channel> channel)
    : channel_(std::move(channel)),
      sheets_(v1::SheetService::NewStub(channel_)),
      cuts_(v1::CutService::NewStub(channel_)),
      interaction_(v1::InteractionService::NewStub(channel_)),
      stream_(v1::StreamService::NewStub(channel_)),
      render_(v1::RenderService::NewStub(channel_)),
      server_(v1::ServerService::NewStub(channel_)),
      store_(v1::StoreService::NewStub(channel_)),
      access_(v1::AccessService::NewStub(channel_)) {}

}  // namespace kerf::client
