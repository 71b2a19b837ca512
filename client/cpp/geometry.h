#pragma once

#include <initializer_list>
#include <span>
#include <string>

#include "kerf/v1/geometry.pb.h"

// Makes points, curves to cut along and cameras, as kerf.v1 takes them. A curve is in metres of material coordinates,
// or in pixels for a cut with a view. The server refuses values out of range, naming the field.
namespace kerf::client {

struct Point {
  double x = 0.0;  // m
  double y = 0.0;  // m
};
struct WeightedPoint {
  double x = 0.0;       // m
  double y = 0.0;       // m
  double weight = 1.0;  // -, 1e-6..1e6
};
struct Vector {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

v1::Vec2 vec2(Point point);
v1::Vec3 vec3(Vector vector);

// Returns straight pieces; closed if the last point equals the first. 2..4096 points.
v1::Curve polyline(std::span<const Point> points);
v1::Curve polyline(std::initializer_list<Point> points);
// Returns n cubic pieces joined end to start, from 3 n + 1 points; n in 1..64.
v1::Curve bezier(std::span<const Point> points);
v1::Curve bezier(std::initializer_list<Point> points);
// Returns a full circle: a punch.
v1::Curve circle(Point center, double radius_m);
// Returns a full ellipse, turned counter-clockwise by rotation_rad.
v1::Curve ellipse(Point center, double semi_axis_x_m, double semi_axis_y_m, double rotation_rad = 0.0);
// Returns the outlines of a drawing, given as SVG text in UTF-8. Without CutOptions::fit and `reading` the drawing is
// fitted into the sheet. `reading` chooses what is cut, and how large; proto/kerf/v1/geometry.proto describes its
// fields.
v1::Curve svg(std::string text, const v1::DrawingReading& reading = {});
// Returns the same of the bytes of a file, in any encoding of XML or compressed by gzip.
v1::Curve svg_data(std::string bytes, const v1::DrawingReading& reading = {});
// Returns the outlines of a DXF drawing, given as the bytes of its file, in the same way.
v1::Curve dxf(std::string bytes, const v1::DrawingReading& reading = {});

// Builds a curve of one or more lines, each made of straight, Bezier and arc pieces:
//   PathBuilder({0.1, 0.1}).line({0.3, 0.1}).arc({0.1, 0.1}, 0.1).close().move({0.6, 0.6}).line({0.8, 0.7}).curve()
class PathBuilder {
 public:
  explicit PathBuilder(Point start) { move(start); }

  PathBuilder& move(Point start);  // Begins a line that is not joined to the one before.
  PathBuilder& line(Point end);
  PathBuilder& quadratic(Point control, Point end);
  PathBuilder& cubic(Point control_1, Point control_2, Point end);
  // Add rational pieces; `start_weight` is the weight of their starting point.
  PathBuilder& quadratic(double start_weight, WeightedPoint control, WeightedPoint end);
  PathBuilder& cubic(double start_weight, WeightedPoint control_1, WeightedPoint control_2, WeightedPoint end);
  struct ArcOptions {
    double semi_axis_y_m = 0.0;  // 0: equal to semi_axis_x_m, a circle.
    double rotation_rad = 0.0;
    bool large = false;  // Takes the longer way round.
    bool counter_clockwise = true;
  };
  PathBuilder& arc(Point end, double semi_axis_x_m, const ArcOptions& options);
  PathBuilder& arc(Point end, double radius_m) { return arc(end, radius_m, ArcOptions{}); }
  PathBuilder& close();  // Ends the line at its start.

  [[nodiscard]] v1::Curve curve() const;

 private:
  v1::Path::Segment& add();

  v1::Path path_;
};

// Returns a perspective camera in the world; `eye` and `target` in metres. Up is +z.
v1::Camera camera(Vector eye, Vector target, double vertical_fov_deg = 40.0);

}  // namespace kerf::client
