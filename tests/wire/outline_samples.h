#pragma once

#include <limits>
#include <vector>

#include "kerf/v1/scene.pb.h"
#include "tests/wire/bad_conditions.h"
#include "tests/wire/condition_samples.h"

namespace kerf::testing {

// Every field given that an encoder writes.
inline void set_outline(v1::Scene& scene) {
  v1::OutlineMesh& outline = *scene.mutable_outline();
  outline.Clear();
  v1::Path::Subpath* border = outline.mutable_boundary()->mutable_path()->add_subpaths();
  set(border->mutable_start(), 0.3, 0.0);
  set(border->add_segments()->mutable_line(), 1.0, 0.0);
  set(border->add_segments()->mutable_line(), 1.0, 1.0);
  set(border->add_segments()->mutable_line(), 0.0, 1.0);
  border->set_closed(true);
  set(outline.add_holes()->mutable_circle()->mutable_center(), 0.5, 0.5);
  outline.mutable_holes(0)->mutable_circle()->set_radius_m(0.1);
  v1::Ellipse& ellipse = *outline.add_holes()->mutable_ellipse();
  set(ellipse.mutable_center(), 0.8, 0.8);
  ellipse.set_semi_axis_x_m(0.1);
  ellipse.set_semi_axis_y_m(0.05);
  ellipse.set_rotation_rad(0.3);
  outline.set_edge_length_m(0.07);
  v1::EdgeLength* size = outline.add_sizes();
  set(size->mutable_point(), 0.6, 0.5);
  size->set_edge_length_m(0.01);
  size->set_growth(0.3);
  size = outline.add_sizes();
  set(size->mutable_curve()->mutable_polyline()->add_points(), 0.7, 0.2);
  set(size->mutable_curve()->mutable_polyline()->add_points(), 0.9, 0.3);
  size->set_edge_length_m(0.02);
  size->set_growth(0.2);
  outline.set_min_angle_deg(27.0);
}

inline std::vector<BadScene> bad_outlines() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  return {
      {"outline.boundary", [](v1::Scene& s) { s.mutable_outline(); }},
      {"outline.boundary", [](v1::Scene& s) { s.mutable_outline()->mutable_boundary(); }},
      {"outline.holes[2]",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->add_holes();
       }},
      {"outline.holes[1].svg.file",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->mutable_holes(1)->mutable_svg()->set_file("leaf.svg");
       }},
      {"outline.holes[0].circle.radius_m",
       [=](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->mutable_holes(0)->mutable_circle()->set_radius_m(nan);
       }},
      {"outline.boundary.path.subpaths[0].segments[1]",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->mutable_boundary()->mutable_path()->mutable_subpaths(0)->mutable_segments(1)->Clear();
       }},
      {"outline.edge_length_m",
       [=](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->set_edge_length_m(infinity);
       }},
      {"outline.sizes[0].place",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->mutable_sizes(0)->clear_place();
       }},
      {"outline.sizes[1].curve",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->mutable_sizes(1)->mutable_curve()->Clear();
       }},
      {"outline.sizes[1].edge_length_m",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->mutable_sizes(1)->clear_edge_length_m();
       }},
      {"outline.sizes[0].growth",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->mutable_sizes(0)->set_growth(-0.25);
       }},
      {"outline.min_angle_deg",
       [](v1::Scene& s) {
         set_outline(s);
         s.mutable_outline()->set_min_angle_deg(29.0);
       }},
  };
}

}  // namespace kerf::testing
