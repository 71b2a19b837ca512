#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "server/core/cut/cut.h"
#include "server/core/cut/view.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/cut/calls.h"

// Sheets in space, cameras that see them, and cuts drawn on their pictures.
namespace kerf::cut {

inline constexpr double kPictureWidth = 800.0;
inline constexpr double kPictureHeight = 600.0;

inline Eigen::Matrix4d look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d back = (eye - target).normalized();
  const Eigen::Vector3d right = up.cross(back).normalized();
  const Eigen::Vector3d upright = back.cross(right);
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.row(0).head<3>() = right;
  view.row(1).head<3>() = upright;
  view.row(2).head<3>() = back;
  view.block<3, 1>(0, 3) = -(view.block<3, 3>(0, 0) * eye);
  return view;
}

inline Eigen::Matrix4d perspective(double vertical_fov) {
  const double f = 1.0 / std::tan(0.5 * vertical_fov);
  const double near = 0.01;
  const double far = 100.0;
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  projection(0, 0) = f * kPictureHeight / kPictureWidth;
  projection(1, 1) = f;
  projection(2, 2) = (far + near) / (near - far);
  projection(2, 3) = 2.0 * far * near / (near - far);
  projection(3, 2) = -1.0;
  return projection;
}

inline View view_from(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                      const Eigen::Vector3d& up = Eigen::Vector3d::UnitY()) {
  View view;
  view.view = look_at(eye, target, up);
  view.projection = perspective(0.7);
  view.width_px = kPictureWidth;
  view.height_px = kPictureHeight;
  return view;
}

inline Eigen::Vector2d pixel(const View& view, const Eigen::Vector3d& world) {
  const Eigen::Vector4d clip = view.projection * (view.view * world.homogeneous());
  return {0.5 * (1.0 + clip.x() / clip.w()) * view.width_px, 0.5 * (1.0 - clip.y() / clip.w()) * view.height_px};
}

// A sheet of 1 m x 1 m with its vertices where `place` puts them.
struct Scene {
  mesh::TriangleMesh mesh;
  linear::VertexField positions;
};

inline Scene scene(int side, const std::function<Eigen::Vector3d(const Eigen::Vector2d&)>& place) {
  Scene made;
  made.mesh = mesh::make_grid({side, side, 1.0, 1.0}).value();
  made.positions.resize(made.mesh.num_vertices());
  for (mesh::VertexId v = 0; v < made.mesh.num_vertices(); ++v) {
    made.positions.col(v) = place(made.mesh.rest_position(v));
  }
  return made;
}

inline Eigen::Vector3d lay_flat(const Eigen::Vector2d& at) {
  return {at.x(), at.y(), 0.0};
}

// Folded along x into `layers`, one below the other by `gap`, the first on top.
inline std::function<Eigen::Vector3d(const Eigen::Vector2d&)> folded(int layers, double gap) {
  return [=](const Eigen::Vector2d& at) {
    const double along = at.x() * layers;
    const double within = along - 2.0 * std::floor(0.5 * along);
    return Eigen::Vector3d((within <= 1.0 ? within : 2.0 - within) / layers, at.y(), -gap * along);
  };
}

// Views the folded sheet of that many layers from straight above.
inline View from_above(int layers) {
  return view_from({0.5 / layers, 0.5, 3.0}, {0.5 / layers, 0.5, 0.0});
}

inline Polyline line_on_picture(const View& view, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Polyline{{pixel(view, from), pixel(view, to)}};
}

inline ViewPath lay(const Scene& s, const Curve& curve, const View& view, double tolerance = 1e-3) {
  const Result<ViewPath> path = project_onto_sheet(s.mesh, s.positions, curve, view, tolerance);
  EXPECT_TRUE(path.ok()) << (path.ok() ? "" : path.error().message);
  return path.ok() ? *path : ViewPath{};
}

inline bool is_closed(const Stroke& stroke) {
  return stroke.points.front() == stroke.points.back();
}

inline double distance_to(const std::vector<Stroke>& strokes, const Eigen::Vector2d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Stroke& stroke : strokes) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      const Eigen::Vector2d a = stroke.points[i];
      const Eigen::Vector2d along = stroke.points[i + 1] - a;
      const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (p - a - t * along).norm());
    }
  }
  return least;
}

inline CutOutcome cut_on_picture(Scene& s, const Curve& curve, const View& view) {
  CutRequest request;
  request.curve = curve;
  request.view = view;
  request.positions = &s.positions;
  const Result<CutPlan> made = plan(s.mesh, request);
  EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
  if (!made.ok()) return {};
  Result<CutOutcome> outcome = apply(s.mesh, *made);
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  EXPECT_EQ(s.mesh.find_violation(), std::nullopt);
  return outcome.ok() ? std::move(outcome).value() : CutOutcome{};
}

}  // namespace kerf::cut
