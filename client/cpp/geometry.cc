#include "client/cpp/geometry.h"

#include <utility>

namespace kerf::client {
namespace {

template <typename Message>
void fill(std::span<const Point> points, Message& message) {
  for (const Point& point : points) *message.add_points() = vec2(point);
}

v1::Vec2 place(const WeightedPoint& point) {
  return vec2({point.x, point.y});
}

}  // namespace

v1::Vec2 vec2(Point point) {
  v1::Vec2 message;
  message.set_x(point.x);
  message.set_y(point.y);
  return message;
}

v1::Vec3 vec3(Vector vector) {
  v1::Vec3 message;
  message.set_x(vector.x);
  message.set_y(vector.y);
  message.set_z(vector.z);
  return message;
}

v1::Curve polyline(std::span<const Point> points) {
  v1::Curve curve;
  fill(points, *curve.mutable_polyline());
  return curve;
}
v1::Curve polyline(std::initializer_list<Point> points) {
  return polyline(std::span(points.begin(), points.size()));
}

v1::Curve bezier(std::span<const Point> points) {
  v1::Curve curve;
  fill(points, *curve.mutable_bezier());
  return curve;
}
v1::Curve bezier(std::initializer_list<Point> points) {
  return bezier(std::span(points.begin(), points.size()));
}

v1::Curve circle(Point center, double radius_m) {
  v1::Curve curve;
  *curve.mutable_circle()->mutable_center() = vec2(center);
  curve.mutable_circle()->set_radius_m(radius_m);
  return curve;
}

v1::Curve ellipse(Point center, double semi_axis_x_m, double semi_axis_y_m, double rotation_rad) {
  v1::Curve curve;
  v1::Ellipse& message = *curve.mutable_ellipse();
  *message.mutable_center() = vec2(center);
  message.set_semi_axis_x_m(semi_axis_x_m);
  message.set_semi_axis_y_m(semi_axis_y_m);
  message.set_rotation_rad(rotation_rad);
  return curve;
}

v1::Curve svg(std::string text, const v1::DrawingReading& reading) {
  v1::Curve curve;
  curve.mutable_svg()->set_text(std::move(text));
  if (reading.ByteSizeLong() > 0) *curve.mutable_svg()->mutable_reading() = reading;
  return curve;
}

v1::Curve svg_data(std::string bytes, const v1::DrawingReading& reading) {
  v1::Curve curve;
  curve.mutable_svg()->set_data(std::move(bytes));
  if (reading.ByteSizeLong() > 0) *curve.mutable_svg()->mutable_reading() = reading;
  return curve;
}

v1::Curve dxf(std::string bytes, const v1::DrawingReading& reading) {
  v1::Curve curve;
  curve.mutable_dxf()->set_data(std::move(bytes));
  if (reading.ByteSizeLong() > 0) *curve.mutable_dxf()->mutable_reading() = reading;
  return curve;
}

PathBuilder& PathBuilder::move(Point start) {
  *path_.add_subpaths()->mutable_start() = vec2(start);
  return *this;
}

PathBuilder& PathBuilder::line(Point end) {
  *add().mutable_line() = vec2(end);
  return *this;
}

PathBuilder& PathBuilder::quadratic(Point control, Point end) {
  v1::Path::Quadratic& piece = *add().mutable_quadratic();
  *piece.mutable_control() = vec2(control);
  *piece.mutable_end() = vec2(end);
  return *this;
}

PathBuilder& PathBuilder::cubic(Point control_1, Point control_2, Point end) {
  v1::Path::Cubic& piece = *add().mutable_cubic();
  *piece.mutable_control_1() = vec2(control_1);
  *piece.mutable_control_2() = vec2(control_2);
  *piece.mutable_end() = vec2(end);
  return *this;
}

PathBuilder& PathBuilder::quadratic(double start_weight, WeightedPoint control, WeightedPoint end) {
  v1::Path::Quadratic& piece = *add().mutable_quadratic();
  *piece.mutable_control() = place(control);
  *piece.mutable_end() = place(end);
  for (const double weight : {start_weight, control.weight, end.weight}) piece.add_weights(weight);
  return *this;
}

PathBuilder& PathBuilder::cubic(double start_weight, WeightedPoint control_1, WeightedPoint control_2,
                                WeightedPoint end) {
  v1::Path::Cubic& piece = *add().mutable_cubic();
  *piece.mutable_control_1() = place(control_1);
  *piece.mutable_control_2() = place(control_2);
  *piece.mutable_end() = place(end);
  for (const double weight : {start_weight, control_1.weight, control_2.weight, end.weight}) piece.add_weights(weight);
  return *this;
}

PathBuilder& PathBuilder::arc(Point end, double semi_axis_x_m, const ArcOptions& options) {
  v1::Path::Arc& piece = *add().mutable_arc();
  piece.set_semi_axis_x_m(semi_axis_x_m);
  piece.set_semi_axis_y_m(options.semi_axis_y_m == 0.0 ? semi_axis_x_m : options.semi_axis_y_m);
  piece.set_rotation_rad(options.rotation_rad);
  piece.set_large(options.large);
  piece.set_counter_clockwise(options.counter_clockwise);
  *piece.mutable_end() = vec2(end);
  return *this;
}

PathBuilder& PathBuilder::close() {
  path_.mutable_subpaths()->rbegin()->set_closed(true);
  return *this;
}

v1::Curve PathBuilder::curve() const {
  v1::Curve curve;
  *curve.mutable_path() = path_;
  return curve;
}

v1::Path::Segment& PathBuilder::add() {
  return *path_.mutable_subpaths()->rbegin()->add_segments();
}

v1::Camera camera(Vector eye, Vector target, double vertical_fov_deg) {
  v1::Camera message;
  *message.mutable_eye() = vec3(eye);
  *message.mutable_target() = vec3(target);
  message.set_vertical_fov_deg(vertical_fov_deg);
  return message;
}

}  // namespace kerf::client
