#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>
#include <variant>

#include "server/service/wire/drawing_codec.h"
#include "server/service/wire/geometry_codec.h"

// Converts kerf.v1.Curve.
namespace kerf::wire {
namespace {

template <typename Points>
std::vector<Eigen::Vector2d> decode_points(const Points& points) {
  std::vector<Eigen::Vector2d> decoded;
  decoded.reserve(static_cast<std::size_t>(points.size()));
  for (const v1::Vec2& point : points) decoded.push_back(decode_vector(point));
  return decoded;
}

// Decodes weights; leaves them as they are if the message has none.
template <typename Numbers, std::size_t count>
Status decode_weights(const Numbers& numbers, std::array<double, count>& weights, const std::string& path) {
  if (numbers.empty()) return Nothing{};
  if (numbers.size() != static_cast<int>(count)) {
    return invalid_argument(
        "LENGTH_MISMATCH",
        path + " has " + std::to_string(numbers.size()) + " numbers; must have none or " + std::to_string(count), path);
  }
  std::copy(numbers.begin(), numbers.end(), weights.begin());
  return Nothing{};
}

Result<cut::Segment> decode_segment(const v1::Path::Segment& message, const std::string& path) {
  switch (message.kind_case()) {
    case v1::Path::Segment::kLine:
      return cut::Segment(cut::LineTo{decode_vector(message.line())});
    case v1::Path::Segment::kQuadratic: {
      const v1::Path::Quadratic& from = message.quadratic();
      cut::QuadraticTo quadratic{decode_vector(from.control()), decode_vector(from.end())};
      KERF_TRY(decode_weights(from.weights(), quadratic.weights, path + ".quadratic.weights"));
      return cut::Segment(quadratic);
    }
    case v1::Path::Segment::kCubic: {
      const v1::Path::Cubic& from = message.cubic();
      cut::CubicTo cubic{{decode_vector(from.control_1()), decode_vector(from.control_2())}, decode_vector(from.end())};
      KERF_TRY(decode_weights(from.weights(), cubic.weights, path + ".cubic.weights"));
      return cut::Segment(cubic);
    }
    case v1::Path::Segment::kArc: {
      const v1::Path::Arc& from = message.arc();
      return cut::Segment(cut::ArcTo{{from.semi_axis_x_m(), from.semi_axis_y_m()},
                                     from.rotation_rad(),
                                     from.large(),
                                     from.counter_clockwise(),
                                     decode_vector(from.end())});
    }
    case v1::Path::Segment::KIND_NOT_SET:
      break;
  }
  return choice_missing(path, "line, quadratic, cubic or arc");
}

Result<cut::Path> decode_path(const v1::Path& message, const std::string& path) {
  cut::Path result;
  for (int i = 0; i < message.subpaths_size(); ++i) {
    const v1::Path::Subpath& from = message.subpaths(i);
    cut::Subpath& subpath = result.subpaths.emplace_back();
    subpath.start = decode_vector(from.start());
    subpath.closed = from.closed();
    for (int k = 0; k < from.segments_size(); ++k) {
      KERF_TRY_ASSIGN(cut::Segment segment,
                      decode_segment(from.segments(k), path + ".subpaths[" + std::to_string(i) + "].segments[" +
                                                           std::to_string(k) + "]"));
      subpath.segments.push_back(segment);
    }
  }
  return result;
}

template <std::size_t count, typename Message>
void encode_weights(const std::array<double, count>& weights, Message& message) {
  const bool all_equal = std::all_of(weights.begin(), weights.end(), [](double weight) { return weight == 1.0; });
  if (!all_equal) message.mutable_weights()->Add(weights.begin(), weights.end());
}

void encode_segment(const cut::LineTo& line, v1::Path::Segment& message) {
  encode_vector(line.end, *message.mutable_line());
}

void encode_segment(const cut::QuadraticTo& quadratic, v1::Path::Segment& message) {
  v1::Path::Quadratic& to = *message.mutable_quadratic();
  encode_vector(quadratic.control, *to.mutable_control());
  encode_vector(quadratic.end, *to.mutable_end());
  encode_weights(quadratic.weights, to);
}

void encode_segment(const cut::CubicTo& cubic, v1::Path::Segment& message) {
  v1::Path::Cubic& to = *message.mutable_cubic();
  encode_vector(cubic.controls[0], *to.mutable_control_1());
  encode_vector(cubic.controls[1], *to.mutable_control_2());
  encode_vector(cubic.end, *to.mutable_end());
  encode_weights(cubic.weights, to);
}

void encode_segment(const cut::ArcTo& arc, v1::Path::Segment& message) {
  v1::Path::Arc& to = *message.mutable_arc();
  to.set_semi_axis_x_m(arc.semi_axes.x());
  to.set_semi_axis_y_m(arc.semi_axes.y());
  to.set_rotation_rad(arc.rotation);
  to.set_large(arc.large);
  to.set_counter_clockwise(arc.counter_clockwise);
  encode_vector(arc.end, *to.mutable_end());
}

void encode(const cut::CubicBezier& bezier, v1::Curve& message) {
  for (const Eigen::Vector2d& point : bezier.points) encode_vector(point, *message.mutable_bezier()->add_points());
}

void encode(const cut::Polyline& polyline, v1::Curve& message) {
  for (const Eigen::Vector2d& point : polyline.points) encode_vector(point, *message.mutable_polyline()->add_points());
}

void encode(const cut::Circle& circle, v1::Curve& message) {
  encode_vector(circle.centre, *message.mutable_circle()->mutable_center());
  message.mutable_circle()->set_radius_m(circle.radius);
}

void encode(const cut::Ellipse& ellipse, v1::Curve& message) {
  encode_vector(ellipse.centre, *message.mutable_ellipse()->mutable_center());
  message.mutable_ellipse()->set_semi_axis_x_m(ellipse.semi_axes.x());
  message.mutable_ellipse()->set_semi_axis_y_m(ellipse.semi_axes.y());
  message.mutable_ellipse()->set_rotation_rad(ellipse.rotation);
}

void encode(const cut::Path& path, v1::Curve& message) {
  for (const cut::Subpath& subpath : path.subpaths) {
    v1::Path::Subpath& to = *message.mutable_path()->add_subpaths();
    encode_vector(subpath.start, *to.mutable_start());
    to.set_closed(subpath.closed);
    for (const cut::Segment& segment : subpath.segments) {
      v1::Path::Segment& one = *to.add_segments();
      std::visit([&one](const auto& each) { encode_segment(each, one); }, segment);
    }
  }
}

}  // namespace

Result<DecodedCurve> decode_curve(const v1::Curve& curve, const std::string& path, const FileReader& read_file,
                                  bool dashes) {
  switch (curve.kind_case()) {
    case v1::Curve::kBezier:
      return DecodedCurve{cut::CubicBezier{decode_points(curve.bezier().points())}, {}, false};
    case v1::Curve::kPolyline:
      return DecodedCurve{cut::Polyline{decode_points(curve.polyline().points())}, {}, false};
    case v1::Curve::kCircle:
      return DecodedCurve{cut::Circle{decode_vector(curve.circle().center()), curve.circle().radius_m()}, {}, false};
    case v1::Curve::kEllipse:
      return DecodedCurve{cut::Ellipse{decode_vector(curve.ellipse().center()),
                                       {curve.ellipse().semi_axis_x_m(), curve.ellipse().semi_axis_y_m()},
                                       curve.ellipse().rotation_rad()},
                          {},
                          false};
    case v1::Curve::kPath: {
      KERF_TRY_ASSIGN(cut::Path decoded, decode_path(curve.path(), path + ".path"));
      return DecodedCurve{std::move(decoded), {}, false};
    }
    case v1::Curve::kSvg:
      return decode_drawing(curve.svg(), path + ".svg", read_file, dashes);
    case v1::Curve::kDxf:
      return decode_drawing(curve.dxf(), path + ".dxf", read_file);
    case v1::Curve::KIND_NOT_SET:
      break;
  }
  return choice_missing(path, "bezier, polyline, circle, ellipse, path, svg or dxf");
}

void encode_curve(const cut::Curve& curve, v1::Curve& message) {
  std::visit([&message](const auto& alternative) { encode(alternative, message); }, curve);
}

}  // namespace kerf::wire
