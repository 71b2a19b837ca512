#pragma once

#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "client/cli/arguments.h"
#include "kerf/v1/render.pb.h"

// Defines the options of `kerf render` and `kerf images`.
namespace kerf::cli {

// Holds the options as typed.
struct PictureOptions {
  std::string size = "640x360";
  std::optional<std::string> view;
  double fov_deg = 0.0;
  bool wireframe = false;
  bool undeformed = false;
  bool dark = false;
  std::string color_by = "sides";
};

struct Picture {
  ImageSize size;
  std::optional<v1::Camera> camera;
  bool wireframe = false;
  bool undeformed = false;
  bool dark = false;
  v1::ColorBy color_by = v1::SIDES;
};

// Adds --size, --view, --fov, --wireframe, --undeformed, --dark, --color-by.
void add_picture_options(CLI::App& command, PictureOptions& options);

Parsed<Picture> parse_picture(const PictureOptions& options);

}  // namespace kerf::cli
