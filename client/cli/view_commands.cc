#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/progress.h"
#include "client/cpp/client.h"
#include "server/host/disk.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;

struct RenderArguments {
  std::string id;
  std::string out;
  std::string size = "640x360";
  std::optional<std::string> view;
  double fov_deg = 0.0;
  bool wireframe = false;
  bool undeformed = false;
  std::string color_by = "sides";
};

// Of an argument that was checked to be one of them.
v1::ColorBy color_by_of(const std::string& name) {
  if (name == "pieces") return v1::PIECES;
  return name == "strains" ? v1::STRAINS : v1::SIDES;
}

int write(const std::string& path, std::string_view content) {
  host::RealDisk disk;
  const Status written = disk.write_file(path, content);
  return written ? kDone : refuse(written.error());
}

int render(const Session& session, const RenderArguments& arguments) {
  const Parsed<ImageSize> size = parse_image_size(arguments.size);
  if (const auto* wrong = std::get_if<UsageError>(&size)) return misuse("--size: " + wrong->message);
  const bool jpeg = has_ending(arguments.out, ".jpg") || has_ending(arguments.out, ".jpeg");
  if (!jpeg && !has_ending(arguments.out, ".png")) return misuse("--out: the file must end in .png, .jpg or .jpeg");

  v1::RenderImageRequest request;
  request.set_name("sheets/" + arguments.id);
  request.set_width_px(std::get<ImageSize>(size).width);
  request.set_height_px(std::get<ImageSize>(size).height);
  request.set_wireframe(arguments.wireframe);
  request.set_undeformed(arguments.undeformed);
  request.set_color_by(color_by_of(arguments.color_by));
  if (arguments.view) {
    const Parsed<v1::Camera> camera = parse_camera(*arguments.view);
    if (const auto* wrong = std::get_if<UsageError>(&camera)) return misuse("--view: " + wrong->message);
    *request.mutable_camera() = std::get<v1::Camera>(camera);
    request.mutable_camera()->set_vertical_fov_deg(arguments.fov_deg);
  }
  request.set_format(jpeg ? v1::RenderImageRequest::JPEG : v1::RenderImageRequest::PNG);
  client::Client client(session.server);
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
  client::Client client(session.server);
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
  client::Client client(session.server);
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
      reply.version().c_str(), session.server.c_str(), reply.uptime_s(), reply.num_sheets(),
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
  command->add_option("--size", arguments->size, "Width and height in pixels, 16..4096 each")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str();
  CLI::Option* view = command->add_option("--view", arguments->view,
                                          "Seen from \"EYE TARGET [UP]\", each x,y,z in metres, as in kerf cut --view "
                                          "(default: all of it)");
  command->add_option("--fov", arguments->fov_deg, "Its vertical field of view, degrees (default 40)")->needs(view);
  command->add_flag("--wireframe", arguments->wireframe, "Draw the triangles' edges");
  command->add_flag("--undeformed", arguments->undeformed,
                    "Draw the sheet as it is cut, but flat: x,y,0 in material coordinates, without colliders");
  command->add_option("--color-by", arguments->color_by, "What colours it: its sides, its pieces, or strains")
      ->check(CLI::IsMember({"sides", "pieces", "strains"}))
      ->capture_default_str();
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
