// Implements `kerf version` and `kerf doctor`.

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <google/protobuf/stubs/common.h>
#include <grpcpp/grpcpp.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/doctor_checks.h"
#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "server/base/memory_limit.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kProtocol = "kerf.v1";
constexpr std::chrono::seconds kAskWithin(5);

// The server's answer, or why there is none.
struct ServerAnswer {
  std::optional<v1::ServerInfo> info;
  std::string failure;  // Empty if there is an answer.
};

ServerAnswer ask_for_info(const ServerTarget& server) {
  const client::Result<client::Secrets> secrets = secrets_of(server);
  if (!secrets) return {std::nullopt, secrets.failure().message};
  client::Client client(client::open_channel(server.address, *secrets, client::Client::Connection::kShared));
  v1::ServerInfo info;
  const grpc::Status status = client.call(&v1::ServerService::Stub::GetServerInfo, client.server(),
                                          v1::GetServerInfoRequest(), info, kAskWithin);
  if (status.ok()) return {std::move(info), ""};
  const client::Failure failure = client::failure_of(status);
  if (failure.code == grpc::StatusCode::UNAVAILABLE)
    return {std::nullopt, "no Kerf server answers at " + server.address};
  return {std::nullopt, failure.message};
}

std::string build() {
#ifdef NDEBUG
  const std::string kind = "release";
#else
  const std::string kind = "with assertions";
#endif
#if defined(__clang__)
  return kind + ", " __VERSION__;
#else
  return kind + ", GCC " __VERSION__;
#endif
}

std::string protobuf_version() {
  return google::protobuf::internal::VersionString(GOOGLE_PROTOBUF_VERSION);
}

int print_version(const Session& session) {
  const ServerAnswer answer = ask_for_info(session.server);
  if (session.json) {
    Json json{{"client",
               {{"version", KERF_VERSION},
                {"protocol", kProtocol},
                {"build", build()},
                {"grpc", grpc::Version()},
                {"protobuf", protobuf_version()}}},
              {"server", nullptr}};
    if (answer.info) {
      json["server"] = {{"address", session.server.address},
                        {"version", answer.info->version()},
                        {"instance_id", answer.info->instance_id()},
                        {"uptime_s", answer.info->uptime_s()},
                        {"renderer", answer.info->renderer()}};
    } else {
      json["server_failure"] = answer.failure;
    }
    std::printf("%s\n", json.dump(2).c_str());
    return kDone;
  }
  std::printf("kerf     %s, protocol %s; %s; gRPC %s, Protocol Buffers %s\n", KERF_VERSION, kProtocol, build().c_str(),
              grpc::Version().c_str(), protobuf_version().c_str());
  if (answer.info) {
    std::printf("server   %s at %s, up %.0f s; pictures: %s\n", answer.info->version().c_str(),
                session.server.address.c_str(), answer.info->uptime_s(), answer.info->renderer().c_str());
  } else {
    std::printf("server   %s\n", answer.failure.c_str());
  }
  return kDone;
}

struct DoctorArguments {
  std::string http = "127.0.0.1:8080";
  std::string data;  // Empty: kerfd's own default.
  std::vector<std::string> certificates;
  bool strict = false;
};

Finding check_server(const ServerTarget& server, const ServerAnswer& answer) {
  if (!answer.info) {
    return {Level::kWarning, "server", answer.failure,
            "start one with kerfd, or give --server HOST:PORT, and a token if it asks"};
  }
  const std::string text = "version " + answer.info->version() + " at " + server.address;
  if (answer.info->version() == KERF_VERSION) return {Level::kOk, "server", text, ""};
  return {Level::kWarning, "server", text + ", and this is kerf " + KERF_VERSION, "use both of one version"};
}

std::int64_t most_open_files() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  return static_cast<std::int64_t>(std::min<rlim_t>(limit.rlim_max, 1'000'000'000));
}

std::int32_t processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
}

std::vector<Finding> examine(const Session& session, const DoctorArguments& arguments) {
  const ServerAnswer answer = ask_for_info(session.server);
  const client::Credentials& credentials = session.server.credentials;
  std::vector<Finding> found{check_server(session.server, answer)};
  for (Finding& finding : check_server_program(find_server_program(), KERF_VERSION))
    found.push_back(std::move(finding));
  found.push_back(check_port("port of gRPC", session.server.address, answer.info.has_value()));
  found.push_back(check_port("port of HTTP", arguments.http, false));
  found.push_back(check_processors(processors()));
  found.push_back(check_memory(memory_limit()));
  found.push_back(check_open_files(most_open_files()));
  if (arguments.data != "none") {
    found.push_back(check_data_folder(arguments.data.empty() ? default_data_folder() : arguments.data));
  }
  const std::int64_t now_s = std::time(nullptr);
  const auto certificate = [&](const std::string& option, const std::string& file) {
    if (!file.empty()) found.push_back(check_certificate(option, file, now_s));
  };
  certificate("--tls-ca", credentials.tls_ca);
  certificate("--tls-cert", credentials.tls_cert);
  for (const std::string& file : arguments.certificates) certificate("--certificate", file);
  if (!credentials.token_file.empty()) found.push_back(check_token_file(credentials.token_file));
  return found;
}

int doctor(const Session& session, const DoctorArguments& arguments) {
  const std::vector<Finding> found = examine(session, arguments);
  const auto count = [&](Level level) {
    return std::count_if(found.begin(), found.end(), [level](const Finding& each) { return each.level == level; });
  };
  const auto problems = count(Level::kProblem);
  const auto warnings = count(Level::kWarning);
  if (session.json) {
    Json json{{"problems", problems}, {"warnings", warnings}, {"findings", Json::array()}};
    for (const Finding& each : found) {
      json["findings"].push_back(
          {{"name", each.name}, {"level", name_of(each.level)}, {"text", each.text}, {"advice", each.advice}});
    }
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    for (const Finding& each : found) {
      std::printf("%-8s %-13s %s\n", name_of(each.level), each.name.c_str(), each.text.c_str());
      if (!each.advice.empty()) std::printf("%-8s %-13s -> %s\n", "", "", each.advice.c_str());
    }
    std::printf("%lld problems, %lld warnings\n", static_cast<long long>(problems), static_cast<long long>(warnings));
  }
  return problems > 0 || (arguments.strict && warnings > 0) ? kFailed : kDone;
}

}  // namespace

void add_doctor_commands(CLI::App& app, Session& session) {
  CLI::App* version = app.add_subcommand(
      "version", "Show the versions of this command, of its protocol and libraries, and of the server");
  version->group(group::kServer);
  version->callback([&session] { session.action = [&session] { return print_version(session); }; });

  const auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* command = app.add_subcommand(
      "doctor",
      "Check what kerf and kerfd need on this machine: a line for each, with what to do\n"
      "Exit code 3 if there is a problem. Example: kerf doctor --data /var/lib/kerf --certificate server.pem");
  command->group(group::kServer);
  command->add_option("--http", arguments->http, "HTTP address at which kerfd is to listen")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  command->add_option("--data", arguments->data, "Data folder of kerfd, or none; its own default unless given")
      ->type_name(value::kFolder);
  command
      ->add_option("--certificate", arguments->certificates,
                   "Certificate whose dates are checked, PEM; may be repeated")
      ->type_name(value::kFile)
      ->take_all();
  command->add_flag("--strict", arguments->strict, "Exit with 3 also for warnings");
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return doctor(session, *arguments); }; });
}

}  // namespace kerf::cli
