#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "kerf/v1/conditions.pb.h"
#include "kerf/v1/geometry.pb.h"
#include "kerf/v1/scene.pb.h"

// Parses the small languages of the command line. Malformed text gives a UsageError with a sentence that shows the
// right form.
namespace kerf::cli {

struct UsageError {
  std::string message;
};
template <typename T>
using Parsed = std::variant<T, UsageError>;

struct GridSize {
  std::int32_t columns = 0;  // Vertices along x.
  std::int32_t rows = 0;     // Vertices along y.
};
struct SheetSize {
  double width = 0.0;   // m
  double height = 0.0;  // m
};
struct ImageSize {
  std::int32_t width = 0;   // pixels
  std::int32_t height = 0;  // pixels
};

// Parses "50x50".
Parsed<GridSize> parse_grid(const std::string& text);
// Parses "1x0.5".
Parsed<SheetSize> parse_size(const std::string& text);
// Parses "640x360".
Parsed<ImageSize> parse_image_size(const std::string& text);
// Parses "x,y x,y ..."; numbers may be nan or inf, which the server refuses by name.
Parsed<std::vector<v1::Vec2>> parse_points(const std::string& text);
// Parses "cx,cy,r".
Parsed<v1::Circle> parse_circle(const std::string& text);
// Parses "cx,cy,rx,ry" or "cx,cy,rx,ry,DEGREES", turned counter-clockwise.
Parsed<v1::Ellipse> parse_ellipse(const std::string& text);
// Parses three or four control points "x,y,w" with weights w: a rational quadratic or cubic Bezier curve.
Parsed<v1::Path> parse_rational(const std::string& text);
// Parses SVG path data in metres, y up, all of which must be well-formed.
Parsed<v1::Path> parse_path(const std::string& text);
// Parses "x0,y0,x1,y1", or "sheet", which gives a box without corners: it means the sheet without its margin.
Parsed<v1::MaterialBox> parse_fit(const std::string& text);
// Parses "x,y,z".
Parsed<v1::Vec3> parse_vector(const std::string& text);
// Parses "top" and the other edges, "corners", "top-corners", "all", "x,y" (the nearest vertex) or "x0,y0,x1,y1" (a
// box).
Parsed<v1::Region> parse_region(const std::string& text);
// Parses "EYE TARGET" or "EYE TARGET UP", each "x,y,z" in metres.
Parsed<v1::Camera> parse_camera(const std::string& text);
// Parses "nearest", "all", "piece", "piece:N" or "depth:NEAREST,FARTHEST" (metres) into layers, piece and depths of a
// view.
Parsed<v1::View> parse_layers(const std::string& text);
// Parses "0.01,0.005[,...]": lengths in metres, cut and left in turn.
Parsed<std::vector<double>> parse_dash(const std::string& text);

// Adds the default port 50051 to a server's address without one: "127.0.0.1", "[::1]", "::1".
std::string with_port(const std::string& address);

// True if `name` ends with `ending`, ignoring case.
bool has_ending(std::string_view name, std::string_view ending);

}  // namespace kerf::cli
