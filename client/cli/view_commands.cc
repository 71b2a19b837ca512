#include <cstdio>
#include <memory>
#include <string>
#include <variant>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/picture_options.h"
#include "client/cli/progress.h"
#include "client/cpp/client.h"
#include "server/base/disk.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;

struct RenderArguments {
  std::string id;
  std::string out;
  PictureOptions picture;
};

int write(const std::string& path, std::string_view content) {
  RealDisk disk;
  const Status written = disk.write_file(path, content);
  return written.ok() ? kDone : refuse(written.error());
}

int render(const Session& session, const RenderArguments& arguments) {
  const Parsed<Picture> picture = parse_picture(arguments.picture);
  if (const auto* wrong = std::get_if<UsageError>(&picture)) return misuse(wrong->message);
  const Picture& wanted = std::get<Picture>(picture);
  const bool jpeg = has_ending(arguments.out, ".jpg") || has_ending(arguments.out, ".jpeg");
  if (!jpeg && !has_ending(arguments.out, ".png")) return misuse("--out: the file must end in .png, .jpg or .jpeg");

  v1::RenderImageRequest request;
  request.set_name("sheets/" + arguments.id);
  request.set_width_px(wanted.size.width);
  request.set_height_px(wanted.size.height);
  request.set_wireframe(wanted.wireframe);
  request.set_undeformed(wanted.undeformed);
  request.set_dark(wanted.dark);
  request.set_color_by(wanted.color_by);
  if (wanted.camera) *request.mutable_camera() = *wanted.camera;
  request.set_format(jpeg ? v1::RenderImageRequest::JPEG : v1::RenderImageRequest::PNG);
  client::Client client = connect(session.server);
  v1::RenderImageResponse response;
  const grpc::Status status = [&] {
    const WaitingNote note(session, "drawing");
    return client.call(&v1::RenderService::Stub::RenderImage, client.render(), request, response);
  }();
  if (!status.ok()) return refuse(status, session.server);
  if (const int code = write(arguments.out, response.image()); code != kDone) return code;
  if (session.json) {
    const Json json{
        {"file", arguments.out},           {"media_type", response.media_type()}, {"tick", response.tick()},
        {"width_px", response.width_px()}, {"height_px", response.height_px()},   {"bytes", response.image().size()}};
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    std::printf("%s: %dx%d, tick %lld\n", arguments.out.c_str(), response.width_px(), response.height_px(),
                static_cast<long long>(response.tick()));
  }
  return kDone;
}

int export_sheet(const Session& session, const std::string& id, const std::string& out) {
  const bool is_gltf = has_ending(out, ".glb");
  if (!is_gltf && !has_ending(out, ".obj")) return misuse("--out: the file must end in .obj or .glb");
  v1::ExportSheetRequest request;
  request.set_format(is_gltf ? v1::ExportSheetRequest::GLTF : v1::ExportSheetRequest::OBJ);
  request.set_name("sheets/" + id);
  client::Client client = connect(session.server);
  v1::ExportSheetResponse response;
  const grpc::Status status = [&] {
    const WaitingNote note(session, "exporting");
    return client.call(&v1::SheetService::Stub::ExportSheet, client.sheets(), request, response);
  }();
  if (!status.ok()) return refuse(status, session.server);
  if (const int code = write(out, response.content()); code != kDone) return code;
  if (session.json) {
    const Json json{{"file", out}, {"media_type", response.media_type()}, {"bytes", response.content().size()}};
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    std::printf("%s: %zu bytes\n", out.c_str(), response.content().size());
  }
  return kDone;
}

int info(const Session& session) {
  client::Client client = connect(session.server);
  v1::ServerInfo reply;
  const grpc::Status status =
      client.call(&v1::ServerService::Stub::GetServerInfo, client.server(), v1::GetServerInfoRequest(), reply);
  if (!status.ok()) return refuse(status, session.server);
  if (session.json) {
    std::printf("%s\n", to_script_json(reply).c_str());
    return kDone;
  }
  std::printf(
      "Kerf %s at %s, up %.0f s\n  sheets    %d of %d\n  workers   %d, %.0f %% needed\n  renderer  %s\n  materials",
      reply.version().c_str(), session.server.address.c_str(), reply.uptime_s(), reply.num_sheets(),
      reply.limits().max_sheets(), reply.workers(), 100.0 * reply.load(), reply.renderer().c_str());
  for (const std::string& preset : reply.material_presets()) std::printf(" %s", preset.c_str());
  std::printf("\n");
  return kDone;
}

void add_render(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render",
                                         "Draw a sheet on the server and save the picture (PNG or JPEG).\n"
                                         "Example: kerf render demo --out frame.png --size 1280x720");
  command->group(group::kLooks);
  add_sheet_id(*command, arguments->id);
  command->add_option("--out", arguments->out, "File to write: .png, .jpg or .jpeg")
      ->required()
      ->type_name(value::kFile);
  add_picture_options(*command, arguments->picture);
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return render(session, *arguments); }; });
}

}  // namespace

void add_view_commands(CLI::App& app, Session& session) {
  add_render(app, session);

  const auto id = std::make_shared<std::string>();
  const auto out = std::make_shared<std::string>();

  CLI::App* exporting =
      app.add_subcommand("export", "Save a sheet as it is now, as a Wavefront OBJ or binary glTF file");
  exporting->group(group::kLooks);
  add_sheet_id(*exporting, *id);
  exporting->add_option("--out", *out, "File to write: .obj or .glb")->required()->type_name(value::kFile);
  exporting->callback(
      [&session, id, out] { session.action = [&session, id, out] { return export_sheet(session, *id, *out); }; });

  CLI::App* about = app.add_subcommand("info", "Show the server: version, renderer, limits, material presets");
  about->group(group::kServer);
  about->callback([&session] { session.action = [&session] { return info(session); }; });
}

}  // namespace kerf::cli
