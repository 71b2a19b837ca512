#include <unistd.h>

#include <chrono>
#include <cmath>
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
#include "client/cli/on_signal.h"
#include "client/cli/watch_meter.h"
#include "client/cpp/client.h"
#include "client/cpp/watcher.h"

namespace kerf::cli {
namespace {

struct WatchArguments {
  std::string id;
  std::int64_t frames = 0;
  double max_rate_hz = 0.0;
  double reconnect_s = 0.0;
};

WatchMeter::Frame measure(const v1::Frame& frame, const client::Mirror& mirror) {
  using std::chrono::duration;
  const double now_us = duration<double, std::micro>(std::chrono::system_clock::now().time_since_epoch()).count();
  WatchMeter::Frame measured;
  measured.at_s = duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  measured.tick = frame.tick();
  measured.bytes = frame.ByteSizeLong();
  measured.age_ms = (now_us - static_cast<double>(frame.stats().published_unix_us())) / 1000.0;
  measured.skipped = frame.stats().skipped();
  measured.vertices = mirror.num_vertices();
  measured.pieces = mirror.num_pieces();
  measured.real_time_factor = frame.stats().real_time_factor();
  return measured;
}

void print_json(const v1::Frame& frame, const WatchMeter::Frame& measured) {
  const nlohmann::ordered_json json{{"sequence", frame.sequence()},
                                    {"tick", frame.tick()},
                                    {"kind", frame.base_tick() < 0 ? "keyframe" : "delta"},
                                    {"bytes", measured.bytes},
                                    {"topology_version", frame.topology_version()},
                                    {"num_vertices", measured.vertices},
                                    {"num_triangles", frame.stats().num_triangles()},
                                    {"pieces", measured.pieces},
                                    {"skipped", measured.skipped},
                                    {"age_ms", measured.age_ms},
                                    {"real_time_factor", measured.real_time_factor}};
  std::printf("%s\n", json.dump().c_str());
  std::fflush(stdout);
}

// Redraws the status line at a terminal, at most ten times a second; elsewhere prints a line per frame.
class FrameLine {
 public:
  explicit FrameLine(const Session& session) : live_(isatty(STDOUT_FILENO) != 0), quiet_(session.quiet) {}

  void show(const WatchMeter& meter, double now_s) {
    if (quiet_ || (live_ && now_s - drawn_s_ < 0.1)) return;
    drawn_s_ = now_s;
    std::printf(live_ ? "\r%s\033[K" : "%s\n", meter.status().c_str());
    std::fflush(stdout);
  }
  void end(const WatchMeter& meter) const {
    if (quiet_ || meter.frames() == 0) return;
    if (live_) std::printf("\r%s\033[K\n", meter.status().c_str());
    std::printf("%s\n", meter.summary().c_str());
  }

 private:
  bool live_;
  bool quiet_;
  double drawn_s_ = -1e9;
};

int watch(const Session& session, const WatchArguments& arguments) {
  const sigset_t interrupts = block_interrupts();  // Before gRPC starts its threads.
  client::Client client = connect(session.server);
  client::Watcher watcher(client);
  const OnSignal interrupted(interrupts, [&watcher] { watcher.stop(); });
  client::WatchOptions options;
  options.max_rate_hz = arguments.max_rate_hz;
  options.reopening.when_lost = std::chrono::milliseconds(std::llround(1e3 * arguments.reconnect_s));
  WatchMeter meter;
  FrameLine line(session);
  const grpc::Status status =
      watcher.run("sheets/" + arguments.id, options, [&](const v1::Frame& frame, const client::Mirror& mirror) {
        const WatchMeter::Frame measured = measure(frame, mirror);
        meter.add(measured);
        if (session.json) {
          print_json(frame, measured);
        } else {
          line.show(meter, measured.at_s);
        }
        return arguments.frames == 0 || meter.frames() < arguments.frames;
      });
  if (!session.json) line.end(meter);
  if (!status.ok()) return refuse(status, session.server);
  if (interrupted.came() || (arguments.frames > 0 && meter.frames() == arguments.frames)) return kDone;
  return refuse_ended(watcher.ended(), meter.frames(), "frames");
}

}  // namespace

void add_watch_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<WatchArguments>();
  CLI::App* command = app.add_subcommand("watch",
                                         "Follow a sheet live: a status line, or with --json a line per frame.\n"
                                         "Shows frames and bytes per second, the age of frames and ticks that were not "
                                         "sent; a summary at the end (Ctrl-C).");
  command->group(group::kLooks);
  add_sheet_id(*command, arguments->id);
  command->add_option("--frames", arguments->frames, "Stop after this many frames; 0: continue until interrupted")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--rate", arguments->max_rate_hz,
                   "At most this many frames per second, 0.001..1000 (default: every tick)")
      ->check(CLI::Range(0.001, 1000.0));
  command
      ->add_option("--reconnect", arguments->reconnect_s,
                   "When the connection is lost, retry for this many seconds, 0..86400")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return watch(session, *arguments); }; });
}

}  // namespace kerf::cli
