#pragma once

// Random curves to cut with: tame and wild, missing and retracing, tiny and long.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <variant>
#include <vector>

#include "server/base/random.h"
#include "server/core/cut/curve.h"
#include "tests/property/random_sheets.h"
#include "tests/support/meshes.h"

namespace kerf::property {

inline Eigen::Vector2d random_point(SeededRandom& random, double margin) {
  return {random.uniform(-margin, 1.0 + margin), random.uniform(-margin, 1.0 + margin)};
}

// One that has material.
inline mesh::VertexId random_vertex_id(SeededRandom& random, const mesh::TriangleMesh& mesh) {
  auto v = static_cast<mesh::VertexId>(random.below(static_cast<std::uint64_t>(mesh.num_vertices())));
  while (!mesh.has_material(v)) v = (v + 1) % mesh.num_vertices();
  return v;
}

inline Eigen::Vector2d random_vertex(SeededRandom& random, const mesh::TriangleMesh& mesh) {
  return mesh.rest_position(random_vertex_id(random, mesh));
}

inline Eigen::Vector2d polar(double angle, double radius) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

inline cut::Curve random_bezier(SeededRandom& random) {
  cut::CubicBezier bezier;
  const std::uint64_t pieces = 1 + random.below(3);
  for (std::uint64_t i = 0; i < 3 * pieces + 1; ++i) bezier.points.push_back(random_point(random, 0.3));
  return bezier;
}

// Winds or jumps about: crosses itself, and single elements many times over where `size` is small.
inline cut::Curve random_scribble(SeededRandom& random, double size) {
  cut::Polyline line;
  const Eigen::Vector2d middle = random_point(random, 0.0);
  const std::uint64_t count = 2 + random.below(12);
  for (std::uint64_t i = 0; i < count; ++i) {
    line.points.push_back(middle + polar(random.uniform(0.0, 2.0 * std::numbers::pi), size * random.uniform()));
  }
  if (random.below(3) == 0) line.points.push_back(line.points.front());
  return line;
}

inline cut::Curve random_spiral(SeededRandom& random) {
  cut::Polyline line;
  const Eigen::Vector2d middle = random_point(random, -0.2);
  const double reach = random.uniform(0.02, 0.4);
  const double turns = random.uniform(0.5, 3.0);
  for (int i = 0; i <= 60; ++i) line.points.push_back(middle + polar(turns * 0.1 * i, reach * i / 60.0));
  return line;
}

inline cut::Curve random_wave(SeededRandom& random) {
  cut::Polyline line;
  const Eigen::Vector2d a = random_point(random, 0.1);
  const Eigen::Vector2d b = random_point(random, 0.1);
  const Eigen::Vector2d across = random.uniform(0.001, 0.1) * Eigen::Vector2d(a.y() - b.y(), b.x() - a.x());
  const std::uint64_t waves = 2 + random.below(30);
  for (std::uint64_t i = 0; i <= waves; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(waves);
    line.points.push_back(a + t * (b - a) + (i % 2 == 0 ? 1.0 : -1.0) * across);
  }
  return line;
}

inline cut::Curve random_hairpin(SeededRandom& random) {
  const Eigen::Vector2d a = random_point(random, 0.1);
  const Eigen::Vector2d b = random_point(random, 0.1);
  const double gap = std::pow(10.0, random.uniform(-9.0, -1.0));
  return cut::Polyline{{a, b, a + Eigen::Vector2d(gap, gap)}};
}

// Through vertices of the mesh as it is: along edges where they are neighbours.
inline cut::Curve random_vertex_path(SeededRandom& random, const mesh::TriangleMesh& mesh) {
  cut::Polyline line{{random_vertex(random, mesh), random_vertex(random, mesh)}};
  if (random.below(2) == 0) {
    mesh::VertexId vertex = random_vertex_id(random, mesh);
    line.points.assign(1, mesh.rest_position(vertex));
    const std::uint64_t steps = 1 + random.below(6);
    for (std::uint64_t i = 0; i < steps; ++i) {
      const std::vector<mesh::VertexId> ring = test::one_ring(mesh, vertex);
      vertex = ring[random.below(ring.size())];
      line.points.push_back(mesh.rest_position(vertex));
    }
  }
  return line;
}

inline cut::Curve random_tiny(SeededRandom& random, const mesh::TriangleMesh& mesh, const Frame& frame) {
  const double size = frame.scale * std::pow(10.0, random.uniform(-12.0, -3.0));
  const Eigen::Vector2d at = random.below(2) == 0 ? frame.at(random_point(random, 0.0)) : random_vertex(random, mesh);
  if (random.below(2) == 0) return cut::Circle{at, size};
  return cut::Polyline{{at, at + size * Eigen::Vector2d(1.0, 0.3), at + size * Eigen::Vector2d(-0.2, 1.0)}};
}

// Along grid lines, as one draws with snapping on.
inline cut::Curve random_grid_line(SeededRandom& random) {
  const double at = static_cast<double>(random.below(11)) / 10.0;
  const double from = random.uniform(-0.2, 1.0);
  const double to = random.uniform(0.0, 1.2);
  if (random.below(2) == 0) return cut::Polyline{{{from, at}, {to, at}}};
  return cut::Polyline{{{at, from}, {at, to}}};
}

inline cut::Segment random_segment(SeededRandom& random) {
  const auto weight = [&random] { return std::pow(10.0, random.uniform(-1.5, 1.5)); };
  switch (random.below(4)) {
    case 0:
      return cut::LineTo{random_point(random, 0.1)};
    case 1:
      return cut::QuadraticTo{random_point(random, 0.3), random_point(random, 0.1), {weight(), weight(), weight()}};
    case 2:
      return cut::CubicTo{{random_point(random, 0.3), random_point(random, 0.3)},
                          random_point(random, 0.1),
                          {weight(), weight(), weight(), weight()}};
    default:
      return cut::ArcTo{{random.uniform(0.01, 0.5), random.uniform(0.01, 0.5)},
                        random.uniform(-6.0, 6.0),
                        random.below(2) == 0,
                        random.below(2) == 0,
                        random_point(random, 0.1)};
  }
}

inline cut::Curve random_path(SeededRandom& random) {
  cut::Path path;
  path.subpaths.resize(1 + random.below(3));
  for (cut::Subpath& subpath : path.subpaths) {
    subpath.start = random_point(random, 0.1);
    for (std::uint64_t i = 0; i <= random.below(4); ++i) subpath.segments.push_back(random_segment(random));
    subpath.closed = random.below(2) == 0;
  }
  return path;
}

inline cut::Curve random_ellipse(SeededRandom& random) {
  const double semi_axis = std::pow(10.0, random.uniform(-3.0, -0.4));
  return cut::Ellipse{
      random_point(random, 0.1), {semi_axis, semi_axis * random.uniform(0.01, 1.0)}, random.uniform(-6.0, 6.0)};
}

// `map` applied to every point, `scale` to radii and semi-axes, which keep their directions.
template <typename Map>
cut::Curve mapped(cut::Curve curve, const Map& map, double scale) {
  if (auto* circle = std::get_if<cut::Circle>(&curve)) *circle = {map(circle->centre), scale * circle->radius};
  if (auto* line = std::get_if<cut::Polyline>(&curve)) {
    for (Eigen::Vector2d& point : line->points) point = map(point);
  }
  if (auto* bezier = std::get_if<cut::CubicBezier>(&curve)) {
    for (Eigen::Vector2d& point : bezier->points) point = map(point);
  }
  if (auto* ellipse = std::get_if<cut::Ellipse>(&curve)) {
    *ellipse = {map(ellipse->centre), scale * ellipse->semi_axes, ellipse->rotation};
  }
  if (auto* path = std::get_if<cut::Path>(&curve)) {
    for (cut::Subpath& subpath : path->subpaths) {
      subpath.start = map(subpath.start);
      for (cut::Segment& segment : subpath.segments) {
        if (auto* quadratic = std::get_if<cut::QuadraticTo>(&segment)) quadratic->control = map(quadratic->control);
        if (auto* cubic = std::get_if<cut::CubicTo>(&segment)) {
          for (Eigen::Vector2d& control : cubic->controls) control = map(control);
        }
        if (auto* arc = std::get_if<cut::ArcTo>(&segment)) arc->semi_axes *= scale;
        std::visit([&map](auto& each) { each.end = map(each.end); }, segment);
      }
    }
  }
  return curve;
}

// A curve of the unit square.
inline cut::Curve random_unit_curve(SeededRandom& random) {
  switch (random.below(11)) {
    case 0:
    case 1:
      return random_bezier(random);
    case 8:
      return random_path(random);
    case 9:
      return random_ellipse(random);
    case 2:
      return random_scribble(random, 0.7);
    case 3:
      return random_scribble(random, 0.03);
    case 4:
      return random_spiral(random);
    case 5:
      return random_wave(random);
    case 6:
      return random_hairpin(random);
    case 7:
      return random_grid_line(random);
    default:
      return cut::Circle{random_point(random, 0.1), std::pow(10.0, random.uniform(-3.0, -0.4))};
  }
}

// A curve for a sheet in `frame`; one in five is one of the `earlier` ones, or as good as.
inline cut::Curve random_curve(SeededRandom& random, const mesh::TriangleMesh& mesh, const Frame& frame,
                               const std::vector<cut::Curve>& earlier) {
  if (!earlier.empty() && random.below(5) == 0) {
    const cut::Curve& old = earlier[random.below(earlier.size())];
    if (random.below(2) == 0) return old;
    const double offset = frame.scale * std::pow(10.0, random.uniform(-14.0, -1.5));
    const Eigen::Vector2d by = polar(random.uniform(0.0, 6.28), offset);
    return mapped(
        old, [&by](const Eigen::Vector2d& point) { return Eigen::Vector2d(point + by); }, 1.0);
  }
  switch (random.below(11)) {
    case 0:
      return random_vertex_path(random, mesh);
    case 1:
      return random_tiny(random, mesh, frame);
    default:
      return mapped(
          random_unit_curve(random), [&frame](const Eigen::Vector2d& point) { return frame.at(point); }, frame.scale);
  }
}

}  // namespace kerf::property
