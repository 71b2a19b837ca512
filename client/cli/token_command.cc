// Implements `kerf token`: new.

#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/output.h"
#include "server/base/disk.h"
#include "server/service/auth/token_file.h"

namespace kerf::cli {
namespace {

struct TokenArguments {
  std::string id;
  std::string scope = "view";
  std::string sheets;
  std::string until;
  std::string tenant;
  std::string file;
  std::string out;
};

// Returns the token file with a line more. A file that is missing counts as empty.
Result<std::string> with_line(Disk& disk, const std::string& path, const std::string& line) {
  Result<std::string> text = disk.read_file(path, auth::kMaxTokenFileBytes);
  if (!text.ok() && text.error().code == ErrorCode::kNotFound) text = std::string();
  KERF_TRY(text);
  if (!text->empty() && text->back() != '\n') *text += '\n';
  *text += line + "\n";
  const Result<auth::TokenFile> parsed = auth::parse_token_file(*text);
  if (!parsed.ok()) return invalid_argument(parsed.error().reason, "\"" + path + "\": " + parsed.error().message);
  return text;
}

// Writes a secret into a new file that only its owner may read.
Status write_secret(const std::string& path, const std::string& secret) {
  const int number = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const auto fault = [&path] {
    return unavailable("FILE_IO", "cannot write \"" + path + "\": " + std::generic_category().message(errno));
  };
  if (number < 0) return fault();
  const std::string line = secret + "\n";
  const bool is_written = ::write(number, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  Status status = is_written && ::fsync(number) == 0 ? Status(Nothing{}) : Status(fault());
  ::close(number);
  return status;
}

int make_token(const Session& session, const TokenArguments& arguments) {
  const auto made = auth::make_token(
      {arguments.id, *auth::scope_named(arguments.scope), arguments.sheets, arguments.until, arguments.tenant});
  if (!made.ok()) return refuse(made.error());
  RealDisk disk;
  const Result<std::string> file = with_line(disk, arguments.file, made->line);
  if (!file.ok()) return refuse(file.error());
  // Writes the secret first: where that fails, the server does not know the token either.
  if (!arguments.out.empty()) {
    if (const Status written = write_secret(arguments.out, made->text); !written.ok()) return refuse(written.error());
  }
  if (const Status written = disk.write_file(arguments.file, *file); !written.ok()) return refuse(written.error());
  if (session.json) {
    nlohmann::ordered_json printed{{"id", arguments.id}, {"file", arguments.file}};
    if (arguments.out.empty()) {
      printed["token"] = made->text;
    } else {
      printed["token_file"] = arguments.out;
    }
    std::printf("%s\n", printed.dump(2).c_str());
  } else if (arguments.out.empty()) {
    std::printf("%s\n", made->text.c_str());
  } else {
    std::printf("%s: the token; %s: its line\n", arguments.out.c_str(), arguments.file.c_str());
  }
  return kDone;
}

}  // namespace

void add_token_commands(CLI::App& app, Session& session) {
  CLI::App* token = app.add_subcommand("token", "Make tokens for a server that asks for them (kerfd --tokens)");
  token->group(group::kServer);
  token->require_subcommand(1);
  const auto arguments = std::make_shared<TokenArguments>();
  CLI::App* made = token->add_subcommand(
      "new",
      "Make a token and print it; the server's file of tokens gets a line without the secret. A running kerfd reads "
      "the file again at SIGHUP.\nExample: kerf token new alice --scope cut --sheets 'alice-*' --file tokens");
  made->add_option("ID", arguments->id, "Name of the token: 1 to 32 small letters, digits and hyphens")->required();
  made->add_option("--scope", arguments->scope,
                   "What it allows: view, also cut sheets that are there, also make and delete them")
      ->check(CLI::IsMember({"view", "cut", "admin"}))
      ->capture_default_str();
  made->add_option("--tenant", arguments->tenant,
                   "Tenant whose limits count, which has a line in the file: it reaches the sheets NAME-*")
      ->type_name("NAME");
  made->add_option("--sheets", arguments->sheets,
                   "Pattern of the ids that it reaches: * any characters, ? one (default: all)")
      ->type_name("PATTERN");
  made->add_option("--until", arguments->until, "Day before which it ends, YYYY-MM-DD by UTC (default: never)")
      ->type_name("DAY");
  made->add_option("--file", arguments->file, "The server's file of tokens; made if it is missing")
      ->type_name("FILE")
      ->required();
  made->add_option("--out", arguments->out, "New file for the token, which only you may read, in place of printing it")
      ->type_name("FILE");
  made->callback(
      [&session, arguments] { session.action = [&session, arguments] { return make_token(session, *arguments); }; });
}

}  // namespace kerf::cli
