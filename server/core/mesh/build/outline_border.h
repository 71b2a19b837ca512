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

// The contours of an outline and the places of their vertices. Follows the refinement of the border of a mesh whose
// first points are these vertices, in order.
class OutlineBorder : public BorderCurves {
 public:
  struct Vertex {
    std::int32_t contour = 0;
    double station = 0.0;  // m, along it
    LatticePoint at;       // on lattice()
  };

  // Without vertices. Errors: OUTLINE_DEGENERATE, OUTLINE_CROSSES, see outline_mesh.h.
  static Result<OutlineBorder> make(const std::vector<OutlineContour>& contours);

  [[nodiscard]] const Lattice& lattice() const { return lattice_; }
  // m; of contour 0.
  [[nodiscard]] const Eigen::AlignedBox2d& bounds() const { return bounds_; }
  // Returns the area of contour 0 less the areas of all others, m^2. Does not check that these lie inside it.
  [[nodiscard]] double area() const;
  [[nodiscard]] const std::string& field(std::int32_t contour) const { return fields_[contour]; }
  // Contour by contour, each in order.
  [[nodiscard]] const std::vector<Vertex>& vertices() const { return vertices_; }
  // The vertex that follows on the same contour.
  [[nodiscard]] std::int32_t next(std::int32_t vertex) const { return next_[vertex]; }

  // Chooses vertices: corners, and between them as divide_stretch() does, but so that nothing lies between an edge and
  // the curve that it stands for. So edges cross no more than the contours do. Returns false if there would be more
  // than `max_vertices`.
  bool divide(const SizeField& sizes, std::int64_t max_vertices);

  // Starts to follow the refinement of a mesh on this lattice, whose points 0..n-1 are the vertices.
  void follow(const Lattice& mesh_lattice);
  [[nodiscard]] LatticePoint between(PointId p, PointId q, double distance) override;
  void add(PointId p, PointId q, PointId added) override;
  void miss(PointId p, PointId q) override;
  [[nodiscard]] bool has_missed() const { return !missed_.empty(); }
  // Adds the places reported by add() and miss() since follow() to the vertices, in order. Returns false if there would
  // be more than `max_vertices`.
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
  std::vector<std::int32_t> next_;  // by vertex
  Lattice mesh_lattice_;
  std::vector<std::int32_t> vertex_of_;  // by PointId
  double proposed_ = 0.0;                // the station of the last place given
  std::vector<Vertex> missed_;           // places that did not become points, one an edge
  std::set<std::array<PointId, 2>> missed_edges_;
};

}  // namespace kerf::mesh
