#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cpp/transfers.h"
#include "server/base/disk.h"

// Implements commands that fetch recordings of live sheets and play them live.
namespace kerf::cli {
namespace {

constexpr std::size_t kMaxUploadedRecordingBytes = std::size_t{128} << 20;  // Limit of a server.

struct PlayArguments {
  std::string file;
  std::string id;
  bool paused = false;
};

int fetch(const Session& session, const std::string& id, const std::string& out) {
  client::Client client = connect(session.server);
  std::string recording;
  const grpc::Status status = client::fetch_recording(client, "sheets/" + id, recording);
  if (!status.ok()) return refuse(status, session.server);
  RealDisk disk;
  if (const Status written = disk.write_file(out, recording); !written.ok()) return refuse(written.error());
  if (session.json) {
    const nlohmann::ordered_json json{{"file", out}, {"bytes", recording.size()}};
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    std::printf("%s: %zu bytes; `kerf replay %s` runs it again\n", out.c_str(), recording.size(), out.c_str());
  }
  return kDone;
}

int play(const Session& session, const PlayArguments& arguments) {
  RealDisk disk;
  const Result<std::string> recording = disk.read_file(arguments.file, kMaxUploadedRecordingBytes);
  if (!recording.ok()) return refuse(recording.error());
  client::Client client = connect(session.server);
  v1::Sheet sheet;
  const grpc::Status status = client::replay_recording(client, arguments.id, arguments.paused, *recording, sheet);
  if (!status.ok()) return refuse(status, session.server);
  print(session, sheet);
  if (!session.json && sheet.replay().torn_bytes() > 0) {
    std::printf("the last %lld bytes of %s are an incomplete entry, left out\n",
                static_cast<long long>(sheet.replay().torn_bytes()), arguments.file.c_str());
  }
  return kDone;
}

}  // namespace

void add_recording_commands(CLI::App& sheet, Session& session) {
  const auto id = std::make_shared<std::string>();
  const auto out = std::make_shared<std::string>();
  CLI::App* record = sheet.add_subcommand("record",
                                          "Save what a sheet has done since it was made, for `kerf replay`.\n"
                                          "Example: kerf sheet record demo --out demo.rec");
  add_sheet_id(*record, *id);
  record->add_option("--out", *out, "File to write")->required()->type_name(value::kFile);
  record->callback([&session, id, out] { session.action = [&session, id, out] { return fetch(session, *id, *out); }; });

  const auto arguments = std::make_shared<PlayArguments>();
  CLI::App* playing = sheet.add_subcommand("play", "Play a recording live as a new sheet, which pauses at its end");
  playing->add_option("FILE", arguments->file, "Recording")->required()->type_name(value::kFile);
  playing->add_option("--id", arguments->id, "Name of the sheet (default: that of the recording, else the server's)");
  playing->add_flag("--paused", arguments->paused, "Start paused");
  playing->callback(
      [&session, arguments] { session.action = [&session, arguments] { return play(session, *arguments); }; });
}

}  // namespace kerf::cli
