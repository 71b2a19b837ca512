// Implements `kerf open` and `kerf access`.

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cpp/client.h"
#include "client/cpp/credentials.h"
#include "client/cpp/failure.h"

namespace kerf::cli {
namespace {

constexpr double kLeastHours = 1.0 / 60.0;
constexpr double kMostHours = 168.0;

struct OpenArguments {
  std::string sheet;  // Empty: all that the caller's token reaches.
  std::string scope;  // Empty: chosen by scope_of().
  std::optional<double> hours;
  bool once = false;
  bool lasting = false;
  std::string viewer;
};

constexpr std::array<std::pair<const char*, v1::Scope>, 3> kScopes{
    {{"view", v1::SCOPE_VIEW}, {"cut", v1::SCOPE_CUT}, {"admin", v1::SCOPE_ADMIN}}};

std::string scope_name(v1::Scope scope) {
  for (const auto& [name, value] : kScopes) {
    if (value == scope) return name;
  }
  return "unknown";
}

std::string describe_access(const v1::Access& access, const std::string& address) {
  if (!access.asks_for_tokens()) return address + " asks for no token: everybody who reaches it may do everything";
  const std::string until =
      access.expires_unix_s() == 0 ? "for good" : "until " + time_of(1'000'000 * access.expires_unix_s());
  std::string text = "token " + access.token_id() + ": scope " + scope_name(access.scope()) + ", sheets " +
                     access.sheets() + ", " + until;
  if (!access.tenant().empty()) text += "\ntenant " + access.tenant() + ":";
  for (const v1::Quota& quota : access.quotas()) {
    std::array<char, 96> line{};
    if (quota.limit() == 0.0) {
      std::snprintf(line.data(), line.size(), "\n  %-13s %10.9g, no limit", quota.name().c_str(), quota.used());
    } else {
      std::snprintf(line.data(), line.size(), "\n  %-13s %10.9g of %.9g", quota.name().c_str(), quota.used(),
                    quota.limit());
    }
    text += line.data();
  }
  return text;
}

int show_access(const Session& session) {
  client::Client client = connect(session.server);
  v1::Access access;
  const grpc::Status status =
      client.call(&v1::AccessService::Stub::GetAccess, client.access(), v1::GetAccessRequest(), access);
  if (!status.ok()) return refuse(status, session.server);
  std::printf("%s\n",
              (session.json ? to_script_json(access) : describe_access(access, session.server.address)).c_str());
  return kDone;
}

// Returns the address of the viewer, without a slash at its end.
Parsed<std::string> viewer_of(const ServerTarget& server, const std::string& option) {
  std::string url = option;
  if (url.empty()) {
    if (const char* usual = std::getenv("KERF_VIEWER")) url = usual;  // NOLINT(concurrency-mt-unsafe)
  }
  if (url.empty()) {
    if (!client::is_on_this_machine(server.address)) {
      return UsageError{"give --viewer URL or KERF_VIEWER: the address of the viewer of " + server.address};
    }
    const client::Credentials& credentials = server.credentials;
    const bool has_tls = credentials.use_tls || !credentials.tls_ca.empty() || !credentials.tls_cert.empty();
    url = has_tls ? "https://127.0.0.1:8080" : "http://127.0.0.1:8080";
  }
  if (!url.starts_with("http://") && !url.starts_with("https://")) {
    return UsageError{"--viewer: \"" + url + "\" is no address such as http://127.0.0.1:8080"};
  }
  url.erase(url.find_last_not_of('/') + 1);
  return url;
}

// Escapes all that has a meaning in the query of a URL.
std::string in_query(const std::string& text) {
  std::string escaped;
  for (const char letter : text) {
    constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.~";
    std::array<char, 4> code{};
    std::snprintf(code.data(), code.size(), "%%%02X", static_cast<unsigned char>(letter));
    escaped += kPlain.find(letter) == std::string_view::npos ? std::string(code.data()) : std::string(1, letter);
  }
  return escaped;
}

// Fills in the rights of the link. A link that opens once is for the caller, and has the caller's own rights; one that
// lasts is for others, and only shows.
grpc::Status set_scope(client::Client& client, const OpenArguments& arguments, v1::CreateLinkRequest& request) {
  request.set_scope(v1::SCOPE_VIEW);
  for (const auto& [name, value] : kScopes) {
    if (arguments.scope == name) request.set_scope(value);
  }
  if (!arguments.scope.empty() || arguments.lasting) return grpc::Status::OK;
  v1::Access access;
  const grpc::Status status =
      client.call(&v1::AccessService::Stub::GetAccess, client.access(), v1::GetAccessRequest(), access);
  request.set_scope(access.scope());
  return status;
}

// `expires_unix_s`: s since 1970; nothing if it never does.
int print_link(const Session& session, const std::string& url, std::optional<std::int64_t> expires_unix_s, bool once) {
  if (session.json) {
    nlohmann::ordered_json json{{"url", url}, {"expires_unix_s", nullptr}};
    if (expires_unix_s) json["expires_unix_s"] = *expires_unix_s;
    std::printf("%s\n", json.dump(2).c_str());
    return kDone;
  }
  std::printf("%s\n", url.c_str());
  if (expires_unix_s && !session.quiet) {  // On stderr, so that a shell can pass the address on.
    std::fprintf(stderr, "opens %s; the login ends at %s\n", once ? "once, within 60 s" : "any number of times",
                 time_of(1'000'000 * *expires_unix_s).c_str());
  }
  return kDone;
}

int open_viewer(const Session& session, const OpenArguments& arguments) {
  const Parsed<std::string> viewer = viewer_of(session.server, arguments.viewer);
  if (const auto* wrong = std::get_if<UsageError>(&viewer)) return misuse(wrong->message);
  const auto& url = std::get<std::string>(viewer);
  v1::CreateLinkRequest request;
  request.set_sheet_id(arguments.sheet);
  request.set_once(!arguments.lasting);
  if (arguments.hours) {
    if (!(*arguments.hours >= kLeastHours && *arguments.hours <= kMostHours)) {
      return misuse("--hours: a login lasts for a minute (0.0167) to a week (168)");
    }
    request.set_lifetime_s(static_cast<std::int32_t>(std::lround(3600.0 * *arguments.hours)));
  }
  client::Client client = connect(session.server);
  v1::AccessLink link;
  grpc::Status status = set_scope(client, arguments, request);
  if (status.ok()) status = client.call(&v1::AccessService::Stub::CreateLink, client.access(), request, link);
  if (!status.ok() && client::failure_of(status).reason == "NO_TOKENS") {
    const std::string query = arguments.sheet.empty() ? "" : "?sheet=" + in_query(arguments.sheet);
    return print_link(session, url + "/" + query, std::nullopt, false);
  }
  if (!status.ok()) return refuse(status, session.server);
  return print_link(session, url + link.path(), link.expires_unix_s(), request.once());
}

}  // namespace

void add_access_commands(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<OpenArguments>();
  CLI::App* open =
      app.add_subcommand("open",
                         "Print an address that opens the viewer, logged in if the server asks for tokens.\n"
                         "Example: xdg-open \"$(kerf open demo)\"");
  open->group(group::kServer);
  open->add_option("ID", arguments->sheet, "The one sheet that the login reaches (default: all of yours)")
      ->type_name(value::kSheet);
  open->add_option("--scope", arguments->scope,
                   "What the login may do (default: what you may; with --lasting to view alone)")
      ->check(CLI::IsMember({"view", "cut", "admin"}));
  open->add_option("--hours", arguments->hours, "Hours for which the login lasts, 0.0167..168 (default: 8)");
  CLI::Option* once =
      open->add_flag("--once", arguments->once, "The address opens once, within a minute, for yourself (default)");
  open->add_flag("--lasting", arguments->lasting, "The address opens again and again, for those you give it to")
      ->excludes(once);
  open->add_option("--viewer", arguments->viewer,
                   "Address of the viewer (or the environment KERF_VIEWER); port 8080 of this machine if the server is "
                   "here")
      ->type_name("URL");
  open->callback(
      [&session, arguments] { session.action = [&session, arguments] { return open_viewer(session, *arguments); }; });

  CLI::App* access = app.add_subcommand("access", "Show what your token lets you do, and until when");
  access->group(group::kServer);
  access->callback([&session] { session.action = [&session] { return show_access(session); }; });
}

}  // namespace kerf::cli
