#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/base/result.h"
#include "server/core/mesh/build/contour.h"
#include "server/core/mesh/build/outline_mesh.h"
#include "server/core/mesh/lattice.h"
#include "server/core/mesh/refine/box_tree.h"
#include "server/core/mesh/refine/refinement.h"
#include "server/core/mesh/refine/size_field.h"

namespace kerf::mesh {

// The contours of an outline and the vertices that divide them. While a mesh with these vertices as its first points is
// refined, it places the points that split border edges on the contours.
class OutlineBorder : public BorderCurves {
 public:
  struct Vertex {
    std::int32_t contour = 0;
    double station = 0.0;  // m, along the contour
    LatticePoint at;       // nearest lattice point, on lattice()
  };

  // Makes a border that has no vertices yet. Errors: OUTLINE_DEGENERATE, OUTLINE_CROSSES, see outline_mesh.h.
  static Result<OutlineBorder> make(const std::vector<OutlineContour>& contours);

  [[nodiscard]] const Lattice& lattice() const { return lattice_; }
  // Bounding box of contour 0, the outer border. m
  [[nodiscard]] const Eigen::AlignedBox2d& bounds() const { return bounds_; }
  // Returns the area of contour 0 less the areas of all others, m^2. Does not check that these lie inside it.
  [[nodiscard]] double area() const;
  [[nodiscard]] const std::string& field(std::int32_t contour) const { return fields_[contour]; }
  // All vertices. After divide() and renew() they are in order: contour by contour, by station. add() appends.
  [[nodiscard]] const std::vector<Vertex>& vertices() const { return vertices_; }
  // Returns the next vertex on the same contour, in the direction of growing station.
  [[nodiscard]] std::int32_t next(std::int32_t vertex) const { return next_[vertex]; }

  // Chooses the vertices: the corners, and stations between them as divide_stretch() finds them. Adds more where
  // another part of a contour lies between an edge and its piece of curve. So edges do not cross if the contours do
  // not. Returns false if more than `max_vertices` would be needed.
  bool divide(const SizeField& sizes, std::int64_t max_vertices);

  // Call before the refinement of a mesh whose points 0..n-1 are the vertices, in order. `mesh_lattice`: lattice of
  // that mesh.
  void follow(const Lattice& mesh_lattice);
  [[nodiscard]] LatticePoint between(PointId p, PointId q, double distance) override;
  void add(PointId p, PointId q, PointId added) override;
  void miss(PointId p, PointId q) override;
  [[nodiscard]] bool has_missed() const { return !missed_.empty(); }
  // Makes vertices of the places reported by add() and miss() since follow(), and sorts all of them. Returns false if
  // there would be more than `max_vertices`.
  bool renew(std::int64_t max_vertices);

 private:
  struct Chord {
    std::int32_t contour = 0;
    std::int32_t index = 0;
    LatticePoint from, to;
  };
  // The part of a contour from one station to a later one.
  struct Span {
    std::int32_t contour = 0;
    double from = 0.0, to = 0.0;
  };

  OutlineBorder(std::vector<Contour> contours, std::vector<std::string> fields, const Lattice& lattice);
  [[nodiscard]] std::vector<Eigen::AlignedBox2d> chord_boxes() const;
  [[nodiscard]] Status check_crossings() const;
  [[nodiscard]] bool conflict(const Chord& a, const Chord& b) const;
  [[nodiscard]] bool are_neighbours(const Chord& a, const Chord& b) const;
  [[nodiscard]] LatticePoint at(std::int32_t contour, double station) const;
  [[nodiscard]] bool can_be_one_edge(const Span& span) const;
  [[nodiscard]] bool append(const Span& span, std::int64_t max_vertices);
  void link();
  [[nodiscard]] double station_after(const Vertex& from, const Vertex& to) const;

  std::vector<Contour> contours_;
  std::vector<std::string> fields_;
  Lattice lattice_;
  Eigen::AlignedBox2d bounds_;
  std::vector<Chord> chords_;  // contour by contour
  BoxTree tree_;               // of chords_, in lattice units
  std::vector<Vertex> vertices_;
  std::vector<std::int32_t> next_;  // the next vertex on the same contour, by vertex
  Lattice mesh_lattice_;
  std::vector<std::int32_t> vertex_of_;  // index into vertices_, by PointId
  double proposed_ = 0.0;                // station of the place that between() returned last
  std::vector<Vertex> missed_;           // places that did not become points, at most one per edge
  std::set<std::array<PointId, 2>> missed_edges_;
};

}  // namespace kerf::mesh
