#pragma once

#include <array>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// Finds lips and border edges near places of a sheet, triangle by triangle.
class NearbyLips {
 public:
  // `budget`: most triangles that all searches together may look at.
  NearbyLips(const mesh::TriangleMesh& mesh, std::int32_t budget) : mesh_(mesh), budget_(budget) {}

  // True if the place is on the sheet. Sets the start of the next search.
  bool is_on_sheet(const Eigen::Vector2d& at);
  // Returns the ends (m) of lips and border edges closer to `at` than `radius` (m). `at` is the place that
  // is_on_sheet() has found last. Once the budget is used up it returns none.
  const std::vector<std::array<Eigen::Vector2d, 2>>& near(const Eigen::Vector2d& at, double radius);

 private:
  const mesh::TriangleMesh& mesh_;
  std::int32_t budget_;
  mesh::TriangleId start_ = mesh::kNone;
  std::vector<std::array<Eigen::Vector2d, 2>> edges_;
  std::vector<mesh::TriangleId> open_;
  std::unordered_set<mesh::TriangleId> seen_;
};

}  // namespace kerf::cut
