#pragma once

// Random sheets to cut: grids and irregular Delaunay meshes, with and without holes, lying straight on the unit square
// or turned, scaled and moved, flat or curved.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "server/base/random.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/refine/delaunay.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::property {

// Maps the unit square, in which sheets and curves are drawn, to material coordinates.
struct Frame {
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();  // a rotation
  double scale = 1.0;                                  // m
  Eigen::Vector2d origin{0.0, 0.0};                    // m

  [[nodiscard]] Eigen::Vector2d at(const Eigen::Vector2d& unit) const { return origin + scale * (turn * unit); }
};

struct RandomSheet {
  mesh::TriangleMesh mesh;
  Frame frame;
};

using Triangles = std::vector<std::array<int, 3>>;

inline Frame random_frame(SeededRandom& random) {
  Frame frame;
  frame.turn = Eigen::Rotation2Dd(random.uniform(0.0, 2.0 * std::numbers::pi)).toRotationMatrix();
  frame.scale = std::pow(10.0, random.uniform(-3.0, 3.0));
  frame.origin = frame.scale * Eigen::Vector2d(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0));
  return frame;
}

inline mesh::GridConfig random_grid(SeededRandom& random) {
  // One in four is coarse: a cut then reaches the border, and the rim of the domain, within an edge length or two.
  const bool is_coarse = random.below(4) == 0;
  const auto side = [&] { return static_cast<std::int32_t>(is_coarse ? 2 + random.below(3) : 6 + random.below(9)); };
  const std::int32_t num_x = side();
  return {num_x, side(), 1.0, 1.0};
}

inline std::vector<Eigen::Vector2d> positions_of(const mesh::TriangleMesh& mesh) {
  std::vector<Eigen::Vector2d> positions;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) positions.push_back(mesh.rest_position(v));
  return positions;
}

inline Triangles triangles_of(const mesh::TriangleMesh& mesh) {
  Triangles triangles;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) triangles.push_back(mesh.vertices(t));
  }
  return triangles;
}

// Points as a mesher for pictures would leave them: denser towards a corner or not, in a square, a disc or an L.
inline std::vector<Eigen::Vector2d> scattered_points(SeededRandom& random) {
  const std::uint64_t outline = random.below(3);
  const double grading = random.below(2) == 0 ? 1.0 : random.uniform(1.5, 3.0);
  const std::uint64_t count = 20 + random.below(180);
  std::vector<Eigen::Vector2d> points;
  while (points.size() < count) {
    const Eigen::Vector2d p(std::pow(random.uniform(), grading), std::pow(random.uniform(), grading));
    if (outline == 1 && (p - Eigen::Vector2d(0.5, 0.5)).norm() > 0.5) continue;
    if (outline == 2 && p.x() > 0.4 && p.y() > 0.4) continue;
    points.push_back(p);
  }
  return points;
}

// The Delaunay triangles of points in the unit square.
inline Triangles delaunay(const std::vector<Eigen::Vector2d>& points) {
  const mesh::Lattice lattice =
      mesh::Lattice::for_bounds(Eigen::AlignedBox2d(Eigen::Vector2d::Zero(), Eigen::Vector2d::Ones()));
  std::vector<mesh::LatticePoint> at;
  for (const Eigen::Vector2d& p : points) at.push_back(lattice.nearest(p));
  mesh::TriangleMesh domain = mesh::make_empty_domain(lattice);
  mesh::MeshEditor editor(domain);
  const std::vector<mesh::PointId> inserted = mesh::insert_delaunay(editor, at);
  std::vector<int> vertex(points.size() + 4, mesh::kNone);
  for (std::size_t i = 0; i < inserted.size(); ++i) vertex[static_cast<std::size_t>(inserted[i])] = static_cast<int>(i);
  Triangles triangles;
  for (mesh::TriangleId t = 0; t < domain.num_triangle_slots(); ++t) {
    std::array<int, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) corners[k] = vertex[static_cast<std::size_t>(domain.points(t)[k])];
    if (*std::min_element(corners.begin(), corners.end()) != mesh::kNone) triangles.push_back(corners);
  }
  return triangles;
}

// Height over longest edge: an import refuses what is too flat, and the hull of scattered points has such triangles.
inline double flatness(const std::vector<Eigen::Vector2d>& points, const std::array<int, 3>& triangle) {
  const auto edge = [&](std::size_t from, std::size_t to) -> Eigen::Vector2d {
    return points[static_cast<std::size_t>(triangle[to])] - points[static_cast<std::size_t>(triangle[from])];
  };
  const double longest_squared =
      std::max({edge(0, 1).squaredNorm(), edge(1, 2).squaredNorm(), edge(2, 0).squaredNorm()});
  Eigen::Matrix2d sides;
  sides << edge(0, 1), edge(0, 2);
  return sides.determinant() / longest_squared;
}

// Leaves out what lies in up to three discs, but never everything.
inline void punch_holes(SeededRandom& random, const std::vector<Eigen::Vector2d>& points, Triangles& triangles) {
  const std::uint64_t holes = 1 + random.below(3);
  for (std::uint64_t i = 0; i < holes; ++i) {
    const Eigen::Vector2d centre(random.uniform(), random.uniform());
    const double radius = random.uniform(0.05, 0.3);
    Triangles left;
    for (const std::array<int, 3>& t : triangles) {
      Eigen::Vector2d middle(0.0, 0.0);
      for (const int v : t) middle += points[static_cast<std::size_t>(v)] / 3.0;
      if ((middle - centre).norm() > radius) left.push_back(t);
    }
    if (!left.empty()) triangles = std::move(left);
  }
}

// Arrays with a vertex for each fan of triangles around a point: fans that touch in one point only, as holes leave
// them, are none of one vertex. Regions are 0, or random labels.
inline mesh::IndexedMesh to_arrays(const std::vector<Eigen::Vector2d>& points, const Triangles& triangles,
                                   const Frame& frame, bool has_regions, SeededRandom& random) {
  std::vector<int> fan(3 * triangles.size());  // a corner: another corner of the same fan, or itself
  std::iota(fan.begin(), fan.end(), 0);
  const auto root = [&fan](int corner) {
    while (fan[static_cast<std::size_t>(corner)] != corner) corner = fan[static_cast<std::size_t>(corner)];
    return corner;
  };
  std::map<std::pair<int, int>, std::pair<int, int>> sides;  // directed edge: the corners at its ends
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const std::pair<int, int> corners{static_cast<int>(3 * t + k), static_cast<int>(3 * t + next)};
      const auto other = sides.find({triangles[t][next], triangles[t][k]});
      sides[{triangles[t][k], triangles[t][next]}] = corners;
      if (other == sides.end()) continue;
      fan[static_cast<std::size_t>(root(corners.first))] = root(other->second.second);
      fan[static_cast<std::size_t>(root(corners.second))] = root(other->second.first);
    }
  }
  std::map<int, int> vertex_of_fan;
  mesh::IndexedMesh arrays;
  arrays.rest.resize(2, static_cast<Eigen::Index>(fan.size()));
  arrays.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, is_new] =
          vertex_of_fan.try_emplace(root(static_cast<int>(3 * t + k)), static_cast<int>(vertex_of_fan.size()));
      if (is_new) arrays.rest.col(at->second) = frame.at(points[static_cast<std::size_t>(triangles[t][k])]);
      arrays.triangles(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(t)) = at->second;
    }
    if (has_regions) arrays.regions.push_back(static_cast<std::int32_t>(random.below(3)));
  }
  arrays.rest.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(vertex_of_fan.size()));
  return arrays;
}

// Waves of a random height and length, stretched along both axes.
inline Eigen::Matrix3Xd random_surface(const Eigen::Matrix2Xd& rest, const Frame& frame, SeededRandom& random) {
  const Eigen::Vector2d stretch(random.uniform(0.5, 2.0), random.uniform(0.5, 2.0));
  const Eigen::Vector2d waves(random.uniform(0.0, 6.0), random.uniform(0.0, 6.0));
  const double height = random.uniform(0.0, 0.3);
  Eigen::Matrix3Xd surface(3, rest.cols());
  for (Eigen::Index v = 0; v < rest.cols(); ++v) {
    const Eigen::Vector2d unit = frame.turn.transpose() * (rest.col(v) - frame.origin) / frame.scale;
    const double lift = height * std::sin(waves.x() * unit.x()) * std::cos(waves.y() * unit.y());
    surface.col(v) = frame.scale * Eigen::Vector3d(stretch.x() * unit.x(), stretch.y() * unit.y(), lift);
  }
  return surface;
}

struct RandomArrays {
  mesh::IndexedMesh arrays;
  Frame frame;
};

// A sheet that is not just a grid on the unit square: turned, scaled and moved, of scattered points, holed, curved, or
// several of these.
inline RandomArrays random_arrays(SeededRandom& random) {
  RandomArrays made;
  std::vector<Eigen::Vector2d> points;
  Triangles triangles;
  if (random.below(2) == 0) {
    const mesh::GridConfig config = random_grid(random);
    const mesh::TriangleMesh grid = random.below(2) == 0 ? mesh::make_grid(config).value()
                                                         : mesh::make_jittered_grid(config, random.next()).value();
    points = positions_of(grid);
    triangles = triangles_of(grid);
  } else {
    constexpr double kFlattest = 1e-4;
    points = scattered_points(random);
    for (const std::array<int, 3>& t : delaunay(points)) {
      if (flatness(points, t) > kFlattest) triangles.push_back(t);
    }
  }
  if (random.below(4) != 0) made.frame = random_frame(random);
  if (random.below(2) == 0) punch_holes(random, points, triangles);
  made.arrays = to_arrays(points, triangles, made.frame, random.below(4) == 0, random);
  if (random.below(4) == 0) made.arrays.surface = random_surface(made.arrays.rest, made.frame, random);
  return made;
}

}  // namespace kerf::property
