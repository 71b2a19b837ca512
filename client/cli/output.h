#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include <google/protobuf/map.h>
#include <grpcpp/support/status.h>

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

// Exit codes that scripts rely on.
enum ExitCode {
  kDone = 0,        // also a cut that missed
  kRefused = 1,     // the reason is on stderr
  kWrongUsage = 2,  // likewise
};

// What every command gets from the options before it.
struct Session {
  std::string server = "127.0.0.1:50051";
  bool json = false;
  bool quiet = false;    // no progress bars and no status line
  bool verbose = false;  // also what the server measured and counted
  // Set by the subcommand that was given; returns an exit code.
  std::function<int()> action;
};

// The JSON form of a message for scripts: snake_case names, defaults printed, 64-bit integers as numbers (protobuf's
// own mapping makes strings of them). `indent`: spaces, or -1 for one line.
std::string to_script_json(const google::protobuf::Message& message, int indent = 2);

// From now on the functions below print JSON, a line: {"error": {"code", "reason", "message", "field"}}. Of the whole
// process, as stderr is, so that whoever finds something wrong need not be told how that is said.
void refuse_in_json();

// Print the reason on stderr and return the exit code. Where a sheet is not there, `server` is asked for names near it.
int refuse(const grpc::Status& status, const std::string& server);
int refuse(client::Failure failure, const std::string& server);
int refuse(const Error& error);
int misuse(const std::string& message);
// A stream that the server ended after so many "frames".
int refuse_ended(const v1::Ended& ended, std::int64_t count, const std::string& of_what);

// Protocol Buffers keep them in no order.
std::map<std::string, std::int64_t> by_name(const google::protobuf::Map<std::string, std::int64_t>& flagged_ticks);

// The first line of a dry run, above what the cut would be.
inline constexpr const char* kDryRun = "Dry run, nothing is cut:";
// The last line of a dry run, of CutResult and CreateCutsResponse.
template <typename Reply>
void print_tick_time(const Reply& reply) {
  std::printf("  a tick would take %.3g ms, takes %.3g ms now, and has %.3g ms\n", 1e-3 * reply.tick_after_us(),
              1e-3 * reply.tick_before_us(), 1e-3 * reply.tick_budget_us());
}

// For people, or with --json all of it; with --verbose more than a line or two.
void print(const Session& session, const v1::Sheet& sheet);
void print(const Session& session, const v1::CutResult& result);
void print(const Session& session, const v1::InteractionResponse& response);

// Texts for people. `verbose` adds lines with what the server measured and counted.
std::string describe(const v1::Sheet& sheet, bool verbose);
std::string describe(const v1::CutResult& result, bool verbose);
std::string describe(const v1::Piece& piece);

}  // namespace kerf::cli
