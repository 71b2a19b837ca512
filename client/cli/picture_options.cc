#include "client/cli/picture_options.h"

#include <variant>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

namespace kerf::cli {
namespace {

// Converts an argument already checked to be valid.
v1::ColorBy color_by_of(const std::string& name) {
  if (name == "pieces") return v1::PIECES;
  return name == "strains" ? v1::STRAINS : v1::SIDES;
}

}  // namespace

void add_picture_options(CLI::App& command, PictureOptions& options) {
  command.add_option("--size", options.size, "Width and height in pixels, 16..4096 each")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str();
  CLI::Option* view = command.add_option("--view", options.view,
                                         "View from \"EYE TARGET [UP]\", each x,y,z in metres, as in kerf cut --view "
                                         "(default: all of it)");
  command.add_option("--fov", options.fov_deg, "Vertical field of view, degrees (default 40)")->needs(view);
  command.add_flag("--wireframe", options.wireframe, "Draw the triangles' edges");
  command.add_flag("--undeformed", options.undeformed,
                   "Draw the sheet as it is cut, but flat: x,y,0 in material coordinates, without colliders");
  command.add_flag("--dark", options.dark, "Use a dark background");
  command.add_option("--color-by", options.color_by, "Colour by side, by piece or by strain")
      ->check(CLI::IsMember({"sides", "pieces", "strains"}))
      ->capture_default_str();
}

Parsed<Picture> parse_picture(const PictureOptions& options) {
  const Parsed<ImageSize> size = parse_image_size(options.size);
  if (const auto* wrong = std::get_if<UsageError>(&size)) return UsageError{"--size: " + wrong->message};
  Picture picture{std::get<ImageSize>(size), {},           options.wireframe,
                  options.undeformed,        options.dark, color_by_of(options.color_by)};
  if (!options.view) return picture;
  const Parsed<v1::Camera> camera = parse_camera(*options.view);
  if (const auto* wrong = std::get_if<UsageError>(&camera)) return UsageError{"--view: " + wrong->message};
  picture.camera = std::get<v1::Camera>(camera);
  picture.camera->set_vertical_fov_deg(options.fov_deg);
  return picture;
}

}  // namespace kerf::cli
