#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
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
#include "client/cli/on_signal.h"
#include "client/cli/picture_options.h"
#include "client/cli/progress.h"
#include "client/cpp/client.h"
#include "client/cpp/image_watcher.h"
#include "server/base/disk.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ImagesArguments {
  std::string id;
  std::string out;
  PictureOptions picture;
  std::string format = "jpeg";
  int quality = 0;
  double max_rate_hz = 0.0;
  std::int64_t count = 0;
};

// Counts the files written.
struct Written {
  std::int64_t pictures = 0;
  std::int64_t bytes = 0;
  std::int64_t skipped = 0;  // Ticks that no picture shows.
  std::int64_t first_tick = 0;
  std::int64_t last_tick = 0;
};

// Returns a name such as "picture-000001.jpg". A shell's *, and ffmpeg's picture-%06d.jpg, give these in order.
std::string file_name(std::int64_t number, const std::string& format) {
  char name[64];
  std::snprintf(name, sizeof name, "picture-%06lld.%s", static_cast<long long>(number),
                format == "png" ? "png" : "jpg");
  return name;
}

Error no_folder(const std::string& what) {
  return invalid_argument("CANNOT_WRITE", what + "; give --out another folder", "--out");
}

// Makes the folder for the pictures. It must not hold pictures of an earlier stream, because the new ones would
// overwrite or mix with them. Its parent must exist, because a path without one may be mistyped.
Status make_folder(const ImagesArguments& arguments) {
  std::error_code error;
  fs::create_directory(arguments.out, error);
  if (error) return no_folder("cannot create " + arguments.out + ": " + error.message());
  const fs::path first = fs::path(arguments.out) / file_name(1, arguments.format);
  if (fs::exists(first, error)) return no_folder(first.string() + " already exists");
  return Nothing{};
}

class Writer {
 public:
  Writer(const Session& session, const ImagesArguments& arguments)
      : session_(session), arguments_(arguments), progress_(session) {}

  // Takes a picture; returns false if no more are wanted.
  bool take(const v1::Image& image) {
    const std::string name = file_name(written_.pictures + 1, arguments_.format);
    const std::string file = (fs::path(arguments_.out) / name).string();
    RealDisk disk;
    if (const Status written = disk.write_file(file, image.data()); !written.ok()) {
      failure_ = written.error();
      return false;
    }
    note(image, file);
    return arguments_.count == 0 || written_.pictures < arguments_.count;
  }

  [[nodiscard]] const Written& written() const { return written_; }
  [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

 private:
  void note(const v1::Image& image, const std::string& file) {
    if (written_.pictures == 0) written_.first_tick = image.tick();
    written_.last_tick = image.tick();
    ++written_.pictures;
    written_.bytes += static_cast<std::int64_t>(image.data().size());
    written_.skipped += image.stats().skipped();
    if (session_.json) {
      const Json json{{"file", file},
                      {"sequence", image.sequence()},
                      {"tick", image.tick()},
                      {"bytes", image.data().size()},
                      {"width_px", image.width_px()},
                      {"height_px", image.height_px()},
                      {"skipped", image.stats().skipped()}};
      std::printf("%s\n", json.dump().c_str());
      std::fflush(stdout);
      return;
    }
    const std::string what = "tick " + std::to_string(image.tick()) + ", " + file;
    const std::string number = std::to_string(written_.pictures);
    if (arguments_.count > 0) {
      progress_.show(static_cast<double>(written_.pictures) / static_cast<double>(arguments_.count),
                     number + " of " + std::to_string(arguments_.count) + ", " + what);
    } else {
      progress_.show(number + " pictures, " + what + "; Ctrl-C ends it");
    }
  }

  const Session& session_;
  const ImagesArguments& arguments_;
  ProgressBar progress_;
  Written written_;
  std::optional<Error> failure_;
};

void print_summary(const ImagesArguments& arguments, const Written& written) {
  std::printf("%lld pictures in %s, %.1f MB, ticks %lld to %lld, %lld skipped\n",
              static_cast<long long>(written.pictures), arguments.out.c_str(),
              1.0e-6 * static_cast<double>(written.bytes), static_cast<long long>(written.first_tick),
              static_cast<long long>(written.last_tick), static_cast<long long>(written.skipped));
}

int images(const Session& session, const ImagesArguments& arguments) {
  const sigset_t interrupts = block_interrupts();  // Before gRPC starts its threads.
  const Parsed<Picture> picture = parse_picture(arguments.picture);
  if (const auto* wrong = std::get_if<UsageError>(&picture)) return misuse(wrong->message);
  const Picture& wanted = std::get<Picture>(picture);
  client::ImageOptions options;
  options.look = {wanted.size.width, wanted.size.height, wanted.camera,    wanted.wireframe,
                  wanted.undeformed, wanted.color_by,    arguments.quality};
  options.look.dark = wanted.dark;
  options.codec = arguments.format == "png" ? v1::IMAGE_PNG : v1::IMAGE_JPEG;
  options.max_rate_hz = arguments.max_rate_hz;
  if (const Status made = make_folder(arguments); !made.ok()) return refuse(made.error());
  client::Client client = connect(session.server);
  client::ImageWatcher watcher(client);
  const OnSignal interrupted(interrupts, [&watcher] { watcher.stop(); });
  Written written;
  std::optional<Error> failure;
  const grpc::Status status = [&] {
    Writer writer(session, arguments);
    const grpc::Status ended = watcher.run("sheets/" + arguments.id, options,
                                           [&writer](const v1::Image& image) { return writer.take(image); });
    written = writer.written();
    failure = writer.failure();
    return ended;
  }();
  if (failure) return refuse(*failure);
  if (!status.ok()) return refuse(status, session.server);
  if (!session.json && written.pictures > 0) print_summary(arguments, written);
  if (interrupted.came() || (arguments.count > 0 && written.pictures == arguments.count)) return kDone;
  return refuse_ended(watcher.ended(), written.pictures, "pictures");
}

}  // namespace

void add_images_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<ImagesArguments>();
  CLI::App* command =
      app.add_subcommand("images",
                         "Save a sheet as it moves, in numbered pictures that the server draws.\n"
                         "Example: kerf images demo --out film --rate 30 --count 300\n"
                         "Each picture shows the newest tick at its time; with --json there is a line per picture. "
                         "A paused sheet is drawn when something changes.\n"
                         "ffmpeg -framerate 30 -i film/picture-%06d.jpg film.mp4 makes a film of them.");
  command->group(group::kLooks);
  add_sheet_id(*command, arguments->id);
  command
      ->add_option("--out", arguments->out,
                   "Folder for picture-000001.jpg and so on; created if it is missing, its\nparent folder is not")
      ->required()
      ->type_name(value::kFolder);
  add_picture_options(*command, arguments->picture);
  command->add_option("--format", arguments->format, "Format of the pictures")
      ->check(CLI::IsMember({"jpeg", "png"}))
      ->capture_default_str();
  command->add_option("--quality", arguments->quality, "JPEG quality, 1..100 (default 80)")->check(CLI::Range(1, 100));
  command
      ->add_option("--rate", arguments->max_rate_hz, "At most this many per second, 0.001..1000 (default: every tick)")
      ->check(CLI::Range(0.001, 1000.0));
  command->add_option("--count", arguments->count, "Stop after this many; 0: continue until interrupted (Ctrl-C)")
      ->check(CLI::NonNegativeNumber);
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return images(session, *arguments); }; });
}

}  // namespace kerf::cli
