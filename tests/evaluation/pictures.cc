#include "tests/evaluation/pictures.h"

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "server/base/check.h"
#include "server/core/cut/curve.h"
#include "server/core/fem/element/state.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/sheet.h"
#include "tests/evaluation/motion.h"
#include "tests/evaluation/thesis_patterns.h"

namespace kerf::evaluation {
namespace {

constexpr double kLipsSize = 0.6;  // of the cut, in 0..1
constexpr int kTicksBeforeLips = 30;
constexpr int kTicksAfterLips = 12;
constexpr double kShownWidth = 0.16;     // m, of material that is shown
constexpr double kShownFlatness = 1e-3;  // m, of curves as drawn
constexpr double kSlant = 0.5;           // sine of the angle between the sheet and the line of sight
const Eigen::Vector2d kShownAt(0.5, 0.5);

// Triangles near kShownAt.
std::vector<mesh::TriangleId> shown_triangles(const mesh::TriangleMesh& mesh) {
  std::vector<mesh::TriangleId> shown;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const auto& v = mesh.vertices(t);
    const Eigen::Vector2d middle =
        (mesh.rest_position(v[0]) + mesh.rest_position(v[1]) + mesh.rest_position(v[2])) / 3.0;
    if ((middle - kShownAt).cwiseAbs().maxCoeff() < 0.5 * kShownWidth) shown.push_back(t);
  }
  return shown;
}

// Right and up in a picture of these triangles from the side: material x to the right, and y to the back on average.
Eigen::Matrix<double, 3, 2> right_and_up(const sheet::Sheet& sheet, const std::vector<mesh::TriangleId>& triangles) {
  Eigen::Matrix<double, 3, 2> sum = Eigen::Matrix<double, 3, 2>::Zero();
  for (const mesh::TriangleId t : triangles) {
    const auto& v = sheet.mesh().vertices(t);
    Eigen::Matrix2d rest;
    Eigen::Matrix<double, 3, 2> moved;
    for (int k = 0; k < 2; ++k) {
      const mesh::VertexId end = v[static_cast<std::size_t>(k) + 1];
      rest.col(k) = sheet.mesh().rest_position(end) - sheet.mesh().rest_position(v[0]);
      moved.col(k) = sheet.state().x.col(end) - sheet.state().x.col(v[0]);
    }
    sum += sheet.mesh().area(t) * moved * rest.inverse();
  }
  sum.col(0).normalize();
  sum.col(1) -= sum.col(0).dot(sum.col(1)) * sum.col(0);
  sum.col(1).normalize();
  const Eigen::Vector3d normal = sum.col(0).cross(sum.col(1));
  sum.col(1) = kSlant * sum.col(1) + std::sqrt(1.0 - kSlant * kSlant) * normal;
  return sum;
}

nlohmann::json seen_from_the_side(const sheet::Sheet& sheet) {
  const mesh::TriangleMesh& mesh = sheet.mesh();
  const std::vector<mesh::TriangleId> shown = shown_triangles(mesh);
  const Eigen::Matrix<double, 3, 2> along = right_and_up(sheet, shown);
  const Eigen::Vector3d origin = sheet.state().x.col(mesh.vertices(shown.front())[0]);
  const auto add = [&](nlohmann::json& to, mesh::VertexId vertex) {
    const Eigen::Vector2d at = along.transpose() * (sheet.state().x.col(vertex) - origin);
    to.push_back(at.x());
    to.push_back(at.y());
  };
  nlohmann::json triangles = nlohmann::json::array(), lips = nlohmann::json::array();
  for (const mesh::TriangleId t : shown) {
    const auto& v = mesh.vertices(t);
    nlohmann::json triangle = nlohmann::json::array();
    for (std::size_t k = 0; k < 3; ++k) {
      add(triangle, v[k]);
      if (mesh.neighbour(t, static_cast<int>(k)) != mesh::kNone) continue;
      nlohmann::json lip = nlohmann::json::array();
      add(lip, v[(k + 1) % 3]);
      add(lip, v[(k + 2) % 3]);
      lips.push_back(lip);
    }
    triangles.push_back(triangle);
  }
  return {{"triangles", triangles}, {"lips", lips}};
}

}  // namespace

nlohmann::json lips_in_motion() {
  nlohmann::json rows = nlohmann::json::array();
  const std::vector<cut::Curve> curves = single_cut(kLipsSize);
  const std::vector<GivenCut> cuts(curves.begin(), curves.end());
  for (const Way& way : {no_optimisation(), thesis(), kerf_default()}) {
    sheet::Sheet sheet = make_sheet(wool_sheet(50), kerf_default());
    for (int i = 0; i < kTicksBeforeLips; ++i) sheet.step({});
    for (const Result<scene::CommandReply>& reply : sheet.step(commands_of(cuts, way)).replies) {
      KERF_CHECK(reply.ok(), "a cut of the evaluation is refused");
    }
    for (int i = 0; i < kTicksAfterLips; ++i) sheet.step({});
    nlohmann::json row = seen_from_the_side(sheet);
    row["way"] = way.name;
    rows.push_back(row);
  }
  return rows;
}

nlohmann::json growing_curves() {
  nlohmann::json rows = nlohmann::json::array();
  const std::pair<const char*, std::function<std::vector<cut::Curve>(double)>> families[] = {
      {"single", single_cut}, {"intersecting", intersecting_cuts}, {"multiple", multiple_cuts}};
  for (const auto& [name, make] : families) {
    for (const int size : {1, 3, 6, 8}) {
      nlohmann::json curves = nlohmann::json::array();
      for (const cut::Curve& curve : make((size - 1) / 7.0)) {
        nlohmann::json points = nlohmann::json::array();
        for (const cut::Stroke& stroke : cut::flatten(curve, kShownFlatness).strokes) {
          for (const Eigen::Vector2d& point : stroke.points) points.push_back({point.x(), point.y()});
        }
        curves.push_back(points);
      }
      rows.push_back({{"family", name}, {"size", size}, {"curves", curves}});
    }
  }
  return rows;
}

}  // namespace kerf::evaluation
