#include "client/cli/server_names.h"

#include <chrono>
#include <optional>

#include "client/cli/connect.h"

namespace kerf::cli {
namespace {

constexpr std::chrono::milliseconds kAnswerLimit{250};

// Makes a unary call. Returns nothing if there is no answer.
template <typename Service, typename Request, typename Response>
std::optional<Response> ask(const ServerTarget& server, Service& (client::Client::*service)(),
                            grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                            const Request& request) {
  const client::Result<client::Secrets> secrets = secrets_of(server);
  if (!secrets) return std::nullopt;
  client::Client client(client::open_channel(server.address, *secrets, client::Client::Connection::kShared));
  Response reply;
  if (!client.call(method, (client.*service)(), request, reply, kAnswerLimit).ok()) return std::nullopt;
  return reply;
}

}  // namespace

std::vector<std::string> sheet_ids(const ServerTarget& server) {
  v1::ListSheetsRequest request;
  request.set_page_size(1000);
  const auto reply = ask(server, &client::Client::sheets, &v1::SheetService::Stub::ListSheets, request);
  std::vector<std::string> ids;
  if (!reply) return ids;
  for (const v1::Sheet& sheet : reply->sheets()) ids.push_back(sheet.name().substr(sheet.name().find('/') + 1));
  return ids;
}

std::vector<std::string> material_presets(const ServerTarget& server) {
  const auto reply =
      ask(server, &client::Client::server, &v1::ServerService::Stub::GetServerInfo, v1::GetServerInfoRequest());
  if (!reply) return {};
  return {reply->material_presets().begin(), reply->material_presets().end()};
}

}  // namespace kerf::cli
