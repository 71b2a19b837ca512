#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include <google/protobuf/map.h>
#include <grpcpp/support/status.h>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/interaction.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "kerf/v1/stream.pb.h"
#include "server/base/result.h"

namespace google::protobuf {
class Message;
}

namespace kerf::cli {

// Lists exit codes that scripts rely on.
enum ExitCode {
  kDone = 0,        // Also for a cut that missed.
  kRefused = 1,     // The reason is on stderr.
  kWrongUsage = 2,  // The reason is on stderr.
  kFailed = 3,      // `kerf load`: a condition of --fail-if holds. `kerf doctor`: there is a problem.
  kUndecided = 4,   // `kerf load`: none holds, and one has too few values.
};

// Names a server, and says how to call it.
struct ServerTarget {
  std::string address = "127.0.0.1:50051";  // HOST:PORT
  client::Credentials credentials = {};
};

// Holds the options common to all commands.
struct Session {
  ServerTarget server = {};
  bool json = false;
  bool quiet = false;    // No progress bars and no status line.
  bool verbose = false;  // Also prints the server's measurements and counts.
  // Set by the subcommand given; returns an exit code.
  std::function<int()> action;
};

// Returns a message as JSON for scripts: snake_case names, defaults printed, 64-bit integers as numbers (protobuf's own
// mapping makes strings of them). `indent`: spaces, or -1 for one line.
std::string to_script_json(const google::protobuf::Message& message, int indent = 2);

// Makes refuse() and misuse() print one line of JSON from now on: {"error": {"code", "reason", "message", "field"}}. It
// applies to the whole process, like stderr, so that code that finds an error need not know the format.
void refuse_in_json();

// Print the reason on stderr and return the exit code. If a sheet is missing, `server` is asked for similar names.
int refuse(const grpc::Status& status, const ServerTarget& server);
int refuse(client::Failure failure, const ServerTarget& server);
int refuse(const Error& error);
int misuse(const std::string& message);
// Reports that the server ended a stream after `count` frames or pictures; `of_what` is the word for them. Returns the
// exit code.
int refuse_ended(const v1::Ended& ended, std::int64_t count, const std::string& of_what);

// Sorts the flags by name, because Protocol Buffers keep them unordered.
std::map<std::string, std::int64_t> by_name(const google::protobuf::Map<std::string, std::int64_t>& flagged_ticks);

// First line of a dry run, above its result.
inline constexpr const char* kDryRun = "Dry run, nothing is cut:";
// Prints the last line of a dry run, from a CutResult or CreateCutsResponse.
template <typename Reply>
void print_tick_time(const Reply& reply) {
  std::printf("  a tick would take %.3g ms of the %.3g ms available; now it takes %.3g ms\n",
              1e-3 * reply.tick_after_us(), 1e-3 * reply.tick_budget_us(), 1e-3 * reply.tick_before_us());
}

// Print a line or two about the message for people, more with --verbose, and all of it as JSON with --json.
void print(const Session& session, const v1::Sheet& sheet);
void print(const Session& session, const v1::CutResult& result);
void print(const Session& session, const v1::InteractionResponse& response);

// Return texts for people. `verbose` adds lines with the server's measurements and counts.
// Returns the local date and time of a moment (us since 1970).
std::string time_of(std::int64_t unix_us);
std::string describe(const v1::Sheet& sheet, bool verbose);
std::string describe(const v1::CutResult& result, bool verbose);
std::string describe(const v1::Piece& piece);

}  // namespace kerf::cli
