#include "client/cli/arguments.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <numbers>
#include <optional>
#include <sstream>
#include <utility>

#include "server/service/offline/files.h"

namespace kerf::cli {
namespace {

template <typename Number>
std::optional<Number> to_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return number;
}

// Parses "AxB" with numbers A and B.
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

// Parses "a,b,c"; returns nothing if a part is no number.
std::optional<std::vector<double>> to_numbers(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string_view part : split(text, ',')) {
    const std::optional<double> number = to_number<double>(part);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

void set(double x, double y, v1::Vec2& point) {
  point.set_x(x);
  point.set_y(y);
}

void set(const std::vector<double>& numbers, v1::Vec3& vector) {
  vector.set_x(numbers[0]);
  vector.set_y(numbers[1]);
  vector.set_z(numbers[2]);
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
  const auto numbers = to_numbers(text);
  if (!numbers || numbers->size() != 3) return no(text, "CX,CY,RADIUS in metres, such as 0.5,0.5,0.1");
  v1::Circle circle;
  set((*numbers)[0], (*numbers)[1], *circle.mutable_center());
  circle.set_radius_m((*numbers)[2]);
  return circle;
}

Parsed<v1::Ellipse> parse_ellipse(const std::string& text) {
  const auto numbers = to_numbers(text);
  if (!numbers || numbers->size() < 4 || numbers->size() > 5) {
    return no(text, "CX,CY,RX,RY in metres and, if it is turned, DEGREES, such as 0.5,0.5,0.2,0.1,30");
  }
  v1::Ellipse ellipse;
  set((*numbers)[0], (*numbers)[1], *ellipse.mutable_center());
  ellipse.set_semi_axis_x_m((*numbers)[2]);
  ellipse.set_semi_axis_y_m((*numbers)[3]);
  if (numbers->size() == 5) ellipse.set_rotation_rad((*numbers)[4] / 180.0 * std::numbers::pi);
  return ellipse;
}

Parsed<v1::Path> parse_rational(const std::string& text) {
  std::vector<std::vector<double>> points;
  std::istringstream words(text);
  std::string word;
  while (words >> word) {
    const auto numbers = to_numbers(word);
    if (!numbers || numbers->size() != 3) {
      return no(word, "points as x,y,WEIGHT with blanks between them, such as \"0.2,0.5,1 0.5,0.9,2 0.8,0.5,1\"");
    }
    points.push_back(*numbers);
  }
  if (points.size() != 3 && points.size() != 4) {
    return no(text, "3 points x,y,WEIGHT for a quadratic Bezier curve or 4 for a cubic one");
  }
  v1::Path path;
  v1::Path::Subpath& subpath = *path.add_subpaths();
  set(points[0][0], points[0][1], *subpath.mutable_start());
  v1::Path::Segment& segment = *subpath.add_segments();
  if (points.size() == 3) {
    v1::Path::Quadratic& quadratic = *segment.mutable_quadratic();
    set(points[1][0], points[1][1], *quadratic.mutable_control());
    set(points[2][0], points[2][1], *quadratic.mutable_end());
    for (const std::vector<double>& point : points) quadratic.add_weights(point[2]);
  } else {
    v1::Path::Cubic& cubic = *segment.mutable_cubic();
    set(points[1][0], points[1][1], *cubic.mutable_control_1());
    set(points[2][0], points[2][1], *cubic.mutable_control_2());
    set(points[3][0], points[3][1], *cubic.mutable_end());
    for (const std::vector<double>& point : points) cubic.add_weights(point[2]);
  }
  return path;
}

Parsed<v1::Path> parse_path(const std::string& text) {
  Result<v1::Path> path = offline::parse_path(text);
  if (!path.ok()) return UsageError{"cannot read the path: " + path.error().message};
  if (path->subpaths().empty())
    return no(text, "a path as in SVG, in metres, such as \"M 0.2,0.2 L 0.8,0.2 A 0.3,0.3 0 0 1 0.2,0.2 Z\"");
  return std::move(path).value();
}

Parsed<v1::MaterialBox> parse_fit(const std::string& text) {
  v1::MaterialBox box;
  if (text == "sheet") return box;
  const auto numbers = to_numbers(text);
  if (!numbers || numbers->size() != 4) return no(text, "X0,Y0,X1,Y1 in metres, such as 0.1,0.1,0.9,0.9, or sheet");
  set((*numbers)[0], (*numbers)[1], *box.mutable_min());
  set((*numbers)[2], (*numbers)[3], *box.mutable_max());
  return box;
}

Parsed<v1::Vec3> parse_vector(const std::string& text) {
  const auto numbers = to_numbers(text);
  if (!numbers || numbers->size() != 3) return no(text, "x,y,z, such as 0,0,-9.81");
  v1::Vec3 vector;
  set(*numbers, vector);
  return vector;
}

Parsed<v1::Region> parse_region(const std::string& text) {
  constexpr std::array<std::pair<std::string_view, v1::Region::Edge>, 6> kEdges = {
      {{"top", v1::Region::TOP},
       {"bottom", v1::Region::BOTTOM},
       {"left", v1::Region::LEFT},
       {"right", v1::Region::RIGHT},
       {"corners", v1::Region::CORNERS},
       {"top-corners", v1::Region::TOP_CORNERS}}};
  v1::Region region;
  for (const auto& [name, edge] : kEdges) {
    if (text == name) region.set_edge(edge);
  }
  if (text == "all") region.set_all(true);
  if (region.region_case() != v1::Region::REGION_NOT_SET) return region;
  const auto numbers = to_numbers(text);
  if (numbers && numbers->size() == 2) {
    set((*numbers)[0], (*numbers)[1], *region.mutable_nearest());
  } else if (numbers && numbers->size() == 4) {
    set((*numbers)[0], (*numbers)[1], *region.mutable_box()->mutable_min());
    set((*numbers)[2], (*numbers)[3], *region.mutable_box()->mutable_max());
  } else {
    return no(text, "top, bottom, left, right, corners, top-corners, all, x,y or x0,y0,x1,y1 in metres");
  }
  return region;
}

Parsed<v1::Camera> parse_camera(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::vector<double>> points;
  for (std::string word; words >> word;) {
    const auto numbers = to_numbers(word);
    if (!numbers || numbers->size() != 3) points.clear();
    if (!numbers || numbers->size() != 3) break;
    points.push_back(*numbers);
  }
  if (points.size() != 2 && points.size() != 3) {
    return no(text, "EYE TARGET or EYE TARGET UP, each x,y,z, such as \"0.5,-2,0.5 0.5,0,0.5\"");
  }
  v1::Camera camera;
  const std::array<v1::Vec3*, 3> parts{camera.mutable_eye(), camera.mutable_target(),
                                       points.size() == 3 ? camera.mutable_up() : nullptr};
  for (std::size_t i = 0; i < points.size(); ++i) set(points[i], *parts[i]);
  return camera;
}

Parsed<v1::View> parse_layers(const std::string& text) {
  v1::View view;
  const std::size_t colon = text.find(':');
  const std::string rule = text.substr(0, colon);
  const bool has_detail = colon != std::string::npos;
  const auto numbers = has_detail ? to_numbers(text.substr(colon + 1)) : std::vector<double>{};
  if (rule == "nearest" && !has_detail) {
    view.set_layers(v1::View::NEAREST);
    return view;
  }
  if (rule == "all" && !has_detail) {
    view.set_layers(v1::View::ALL);
    return view;
  }
  if (rule == "piece" && !has_detail) {
    view.set_layers(v1::View::ONE_PIECE);
    return view;
  }
  if (rule == "piece") {
    if (const auto piece = to_number<std::int32_t>(std::string_view(text).substr(colon + 1))) {
      view.set_layers(v1::View::ONE_PIECE);
      view.set_piece(*piece);
      return view;
    }
  }
  if (rule == "depth" && numbers && numbers->size() == 2) {
    view.set_layers(v1::View::DEPTH_RANGE);
    view.set_nearest_m((*numbers)[0]);
    view.set_farthest_m((*numbers)[1]);
    return view;
  }
  return no(text, "nearest, all, piece, piece:2 or depth:1.5,2 (metres from the camera)");
}

Parsed<std::vector<double>> parse_dash(const std::string& text) {
  auto numbers = to_numbers(text);
  if (!numbers) return no(text, "lengths in metres that are cut and left in turn, such as 0.01,0.005");
  return std::move(*numbers);
}

std::string with_port(const std::string& address) {
  const std::string port = ":50051";
  const auto colons = std::count(address.begin(), address.end(), ':');
  if (colons == 0 || (address.front() == '[' && address.back() == ']')) return address + port;
  const bool bare_v6 = colons > 1 && address.find_first_not_of("0123456789abcdefABCDEF:.") == std::string::npos;
  return bare_v6 ? "[" + address + "]" + port : address;
}

bool has_ending(std::string_view name, std::string_view ending) {
  if (name.size() < ending.size()) return false;
  return std::equal(ending.begin(), ending.end(), name.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

}  // namespace kerf::cli
