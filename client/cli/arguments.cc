#include "client/cli/arguments.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <sstream>

namespace kerf::cli {
namespace {

template <typename Number>
std::optional<Number> to_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return number;
}

// "AxB" with A and B numbers.
template <typename Number>
std::optional<std::pair<Number, Number>> to_pair(const std::string& text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos) return std::nullopt;
  const std::optional<Number> first = to_number<Number>(std::string_view(text).substr(0, cross));
  const std::optional<Number> second = to_number<Number>(std::string_view(text).substr(cross + 1));
  if (!first || !second) return std::nullopt;
  return std::pair(*first, *second);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

UsageError no(const std::string& text, const std::string& form) {
  return {"cannot read '" + text + "': write " + form};
}

}  // namespace

Parsed<GridSize> parse_grid(const std::string& text) {
  const auto pair = to_pair<std::int32_t>(text);
  if (!pair) return no(text, "COLUMNSxROWS in vertices, such as 50x50");
  return GridSize{pair->first, pair->second};
}

Parsed<SheetSize> parse_size(const std::string& text) {
  const auto pair = to_pair<double>(text);
  if (!pair) return no(text, "WIDTHxHEIGHT in metres, such as 1x0.5");
  return SheetSize{pair->first, pair->second};
}

Parsed<ImageSize> parse_image_size(const std::string& text) {
  const auto pair = to_pair<std::int32_t>(text);
  if (!pair) return no(text, "WIDTHxHEIGHT in pixels, such as 640x360");
  return ImageSize{pair->first, pair->second};
}

Parsed<std::vector<v1::Vec2>> parse_points(const std::string& text) {
  std::vector<v1::Vec2> points;
  std::istringstream words(text);
  std::string word;
  while (words >> word) {
    const std::vector<std::string_view> parts = split(word, ',');
    const std::optional<double> x = parts.size() == 2 ? to_number<double>(parts[0]) : std::nullopt;
    const std::optional<double> y = parts.size() == 2 ? to_number<double>(parts[1]) : std::nullopt;
    if (!x || !y) return no(word, "points as x,y in metres with blanks between them, such as \"0.2,0.5 0.8,0.5\"");
    v1::Vec2& point = points.emplace_back();
    point.set_x(*x);
    point.set_y(*y);
  }
  if (points.empty()) return no(text, "at least one point x,y");
  return points;
}

Parsed<v1::Circle> parse_circle(const std::string& text) {
  const std::vector<std::string_view> parts = split(text, ',');
  std::vector<double> numbers;
  for (const std::string_view part : parts) {
    const std::optional<double> number = to_number<double>(part);
    if (number) numbers.push_back(*number);
  }
  if (parts.size() != 3 || numbers.size() != 3) return no(text, "CX,CY,RADIUS in metres, such as 0.5,0.5,0.1");
  v1::Circle circle;
  circle.mutable_center()->set_x(numbers[0]);
  circle.mutable_center()->set_y(numbers[1]);
  circle.set_radius_m(numbers[2]);
  return circle;
}

bool has_ending(std::string_view name, std::string_view ending) {
  if (name.size() < ending.size()) return false;
  return std::equal(ending.begin(), ending.end(), name.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

}  // namespace kerf::cli
