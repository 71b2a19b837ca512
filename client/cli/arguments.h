#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "kerf/v1/geometry.pb.h"

// The small languages of the command line. What cannot be read is a UsageError with a sentence that shows the right
// form.
namespace kerf::cli {

struct UsageError {
  std::string message;
};
template <typename T>
using Parsed = std::variant<T, UsageError>;

struct GridSize {
  std::int32_t columns = 0;  // vertices along x
  std::int32_t rows = 0;     // vertices along y
};
struct SheetSize {
  double width = 0.0;   // m
  double height = 0.0;  // m
};
struct ImageSize {
  std::int32_t width = 0;   // pixels
  std::int32_t height = 0;  // pixels
};

// "50x50"
Parsed<GridSize> parse_grid(const std::string& text);
// "1x0.5"
Parsed<SheetSize> parse_size(const std::string& text);
// "640x360"
Parsed<ImageSize> parse_image_size(const std::string& text);
// "x,y x,y ..."; numbers may be nan or inf, which the server refuses by name.
Parsed<std::vector<v1::Vec2>> parse_points(const std::string& text);
// "cx,cy,r"
Parsed<v1::Circle> parse_circle(const std::string& text);

// Whether `name` ends with `ending`, letter case ignored.
bool has_ending(std::string_view name, std::string_view ending);

}  // namespace kerf::cli
