#include "client/cpp/server.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "client/cpp/client.h"
#include "client/cpp/connection.h"
#include "client/cpp/transfers.h"

namespace kerf::client {
namespace {

std::string id_of(const v1::Sheet& sheet) {
  return sheet.name().substr(sheet.name().find('/') + 1);
}

}  // namespace

Server::Server(const std::string& address, const ServerOptions& options)
    : connection_(std::make_shared<Connection>(address, options.credentials, options.timeout)) {}

Result<v1::ServerInfo> Server::info() {
  return connection_->call(&v1::ServerService::Stub::GetServerInfo, client().server(), v1::GetServerInfoRequest());
}

Result<v1::StoreInfo> Server::store_info() {
  return connection_->call(&v1::StoreService::Stub::GetStoreInfo, client().store(), v1::GetStoreInfoRequest());
}

Result<v1::PruneStoreResponse> Server::prune_store() {
  return connection_->call(&v1::StoreService::Stub::PruneStore, client().store(), v1::PruneStoreRequest());
}

Result<Done> Server::delete_set_aside(std::int64_t number) {
  v1::DeleteSetAsideSheetRequest request;
  request.set_number(number);
  const auto reply = connection_->call(&v1::StoreService::Stub::DeleteSetAsideSheet, client().store(), request);
  if (!reply) return reply.failure();
  return Done{};
}

Result<v1::StoreBackup> Server::backup_store(const std::string& backup_id) {
  v1::BackupStoreRequest request;
  request.set_backup_id(backup_id);
  return connection_->call(&v1::StoreService::Stub::BackupStore, client().store(), request);
}

Result<v1::Access> Server::access() {
  return connection_->call(&v1::AccessService::Stub::GetAccess, client().access(), v1::GetAccessRequest());
}

Result<v1::AccessLink> Server::create_link(const LinkOptions& options) {
  constexpr std::int64_t kMostSeconds = std::numeric_limits<std::int32_t>::max();
  v1::CreateLinkRequest request;
  request.set_scope(options.scope);
  request.set_sheet_id(options.sheet_id);
  // Keeps a lifetime that is too long too long, so that the server refuses it.
  request.set_lifetime_s(
      static_cast<std::int32_t>(std::clamp(std::int64_t{options.lifetime.count()}, -kMostSeconds, kMostSeconds)));
  request.set_once(options.once);
  return connection_->call(&v1::AccessService::Stub::CreateLink, client().access(), request);
}

Result<Sheet> Server::create(const v1::Scene& scene, const CreateOptions& options) {
  v1::CreateSheetRequest request;
  *request.mutable_scene() = scene;
  request.set_sheet_id(options.id);
  request.set_paused(options.paused);
  request.set_request_id(options.request_id);
  v1::Sheet made;
  const grpc::Status status = create_sheet(client(), std::move(request), made, connection_->timeout());
  if (!status.ok()) return failure_of(status);
  return sheet(id_of(made));
}

Result<Sheet> Server::replay(const std::string& recording, const std::string& id, bool paused) {
  v1::Sheet made;
  const grpc::Status status = replay_recording(client(), id, paused, recording, made, connection_->timeout());
  if (!status.ok()) return failure_of(status);
  return sheet(id_of(made));
}

Result<std::vector<Sheet>> Server::sheets() {
  v1::ListSheetsRequest request;
  request.set_page_size(1000);
  std::vector<Sheet> all;
  do {
    const auto page = connection_->call(&v1::SheetService::Stub::ListSheets, client().sheets(), request);
    if (!page) return page.failure();
    for (const v1::Sheet& each : page->sheets()) all.push_back(sheet(id_of(each)));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return all;
}

Sheet Server::sheet(const std::string& id) const {
  return {connection_, id};
}

Client& Server::client() {
  return connection_->client();
}

}  // namespace kerf::client
