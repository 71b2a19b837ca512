#include "client/cli/server_names.h"

#include <chrono>

#include "client/cpp/client.h"

namespace kerf::cli {
namespace {

constexpr std::chrono::milliseconds kAnswerLimit{250};

}  // namespace

std::vector<std::string> sheet_ids(const std::string& address) {
  client::Client client(address);
  v1::ListSheetsRequest request;
  request.set_page_size(1000);
  v1::ListSheetsResponse reply;
  std::vector<std::string> ids;
  if (!client.call(&v1::SheetService::Stub::ListSheets, client.sheets(), request, reply, kAnswerLimit).ok()) return ids;
  for (const v1::Sheet& sheet : reply.sheets()) ids.push_back(sheet.name().substr(sheet.name().find('/') + 1));
  return ids;
}

std::vector<std::string> material_presets(const std::string& address) {
  client::Client client(address);
  v1::ServerInfo reply;
  const grpc::Status status = client.call(&v1::ServerService::Stub::GetServerInfo, client.server(),
                                          v1::GetServerInfoRequest(), reply, kAnswerLimit);
  if (!status.ok()) return {};
  return {reply.material_presets().begin(), reply.material_presets().end()};
}

}  // namespace kerf::cli
