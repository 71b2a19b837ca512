#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::scene {

// A mesh and the start positions of its vertices in the world.
struct BuiltMesh {
  mesh::TriangleMesh mesh;
  Eigen::Matrix3Xd positions;              // 3 x V, m
  std::vector<ComponentPlace> components;  // by index into SheetConfig::components
  std::vector<std::string> notes;          // what readers of mesh files mended, guessed or left out, for people

  // Returns the larger side of the bounding box in material coordinates, m; that of the largest component, if there are
  // any.
  [[nodiscard]] double size() const;

  // Returns the point of the mesh at, or nearest to, `material` (m, material coordinates).
  [[nodiscard]] MaterialPoint at(const Eigen::Vector2d& material) const;
  // Returns the gradient (-) of the start position by material coordinates, in the triangle that holds the point.
  [[nodiscard]] Eigen::Matrix<double, 3, 2> gradient_at(const MaterialPoint& point) const;
};

// The mesh of one source.
struct SourceMesh {
  mesh::TriangleMesh mesh;
  Eigen::Matrix3Xd positions;      // 3 x V, m, start in the world as the source gives it; or 3 x 0: Placement gives it
  Eigen::Matrix3Xd surface;        // 3 x V, m, rest shape in space; or 3 x 0 if it is flat
  std::vector<std::string> notes;  // of the reader of a mesh file, for people
};

// Builds the mesh of a valid source. Errors: those of the mesh importers and of outline_source.h, with the field as in
// kerf.v1.Scene. An outline with more than `max_vertices` vertices is refused; for other sources the caller checks
// their number.
Result<SourceMesh> build_source(const MeshSource& source, std::int32_t max_vertices);

// Returns the start positions in the world of all vertices, 3 x V, m.
Eigen::Matrix3Xd place(const mesh::TriangleMesh& mesh, const Placement& placement);

// Builds the mesh of a valid config, from its source or its components. Errors: those of build_source() and
// build_components().
Result<BuiltMesh> build_mesh(const SheetConfig& config);

}  // namespace kerf::scene
