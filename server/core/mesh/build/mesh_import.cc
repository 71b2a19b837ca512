#include "server/core/mesh/build/mesh_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "server/base/check.h"
#include "server/base/interruption.h"
#include "server/core/mesh/build/facets.h"
#include "server/core/mesh/build/flattening.h"
#include "server/core/mesh/build/void_fill.h"

namespace kerf::mesh {
namespace {

// The edge of a triangle opposite its corner `corner`, directed. The ends are vertices or points.
struct Side {
  std::int32_t from = kNone;
  std::int32_t to = kNone;
  TriangleId triangle = kNone;
  int corner = 0;

  [[nodiscard]] std::pair<std::int32_t, std::int32_t> ends() const { return std::minmax(from, to); }
};

std::string id(std::int64_t number) {
  return std::to_string(number);
}

// Returns the least height of a triangle over its longest edge (-); 0 if it has no area. Correct to a few roundings, as
// the area is exact.
double flatness(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const double longest = static_cast<double>(std::max({dot(a, b, a, b), dot(b, c, b, c), dot(c, a, c, a)}));
  return longest == 0.0 ? 0.0 : std::abs(static_cast<double>(doubled_area(a, b, c))) / longest;
}

class SheetImport {
 public:
  SheetImport(const IndexedMesh& input, const ElementNames& names) : input_(input), names_(names) {}

  Result<TriangleMesh> run() {
    using Step = Status (SheetImport::*)();
    for (const Step step : {&SheetImport::check_arrays, &SheetImport::quantise, &SheetImport::orient,
                            &SheetImport::join_triangles, &SheetImport::check_vertices, &SheetImport::curve}) {
      KERF_TRY((this->*step)());
    }
    data_.num_solid_triangles = num_triangles();
    KERF_TRY(fill_void(data_, border_, names_));
    label_pieces();
    anchor();
    measure();
    TriangleMesh mesh(std::move(data_));
#ifdef KERF_VALIDATE
    if (const std::optional<std::string> violation = mesh.find_violation()) KERF_CHECK(false, violation->c_str());
#endif
    return mesh;
  }

  // Checks only the arrays, and builds nothing.
  Status check() {
    return check_arrays();
  }

 private:
  [[nodiscard]] std::int32_t num_vertices() const {
    return static_cast<std::int32_t>(input_.rest.cols());
  }
  [[nodiscard]] std::int32_t num_triangles() const {
    return static_cast<std::int32_t>(input_.triangles.cols());
  }

  Status check_arrays() {
    if (num_vertices() == 0 || num_triangles() == 0) {
      return invalid_argument("MESH_EMPTY", "a sheet has at least one triangle", "triangles");
    }
    if (input_.rest.cols() > kMaxVertices || input_.triangles.cols() > 2 * static_cast<std::int64_t>(kMaxVertices)) {
      return invalid_argument("MESH_TOO_LARGE",
                              id(input_.rest.cols()) + " vertices and " + id(input_.triangles.cols()) +
                                  " triangles; the limits are " + id(kMaxVertices) + " and " +
                                  id(2 * static_cast<std::int64_t>(kMaxVertices)),
                              "rest");
    }
    for (std::int32_t v = 0; v < num_vertices(); ++v) {
      const Eigen::Vector2d position = input_.rest.col(v);
      if (!position.allFinite())
        return invalid_argument("MESH_NOT_FINITE", names_.vertex(v) + " is not finite", "rest");
      if (position.cwiseAbs().maxCoeff() > kMaxRestCoordinate) {
        return invalid_argument("MESH_OUT_OF_RANGE", names_.vertex(v) + " is farther than 1e4 m from the origin",
                                "rest");
      }
    }
    std::vector<bool> is_used(static_cast<std::size_t>(num_vertices()));
    for (TriangleId t = 0; t < num_triangles(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const std::int32_t v = input_.triangles(k, t);
        if (v < 0 || v >= num_vertices()) {
          return invalid_argument(
              "MESH_INDEX", "triangle " + id(t) + " names vertex " + id(v) + " of " + id(num_vertices()), "triangles");
        }
        is_used[v] = true;
      }
    }
    for (std::int32_t v = 0; v < num_vertices(); ++v) {
      interruption_point();
      if (!is_used[v]) return invalid_argument("MESH_UNUSED_VERTEX", "no triangle uses " + names_.vertex(v), "rest");
    }
    return check_surface();
  }

  Status check_surface() {
    if (input_.surface.cols() == 0) return check_regions();
    if (input_.surface.cols() != input_.rest.cols()) {
      return invalid_argument(
          "MESH_SURFACE",
          "the rest surface has " + id(input_.surface.cols()) + " positions for " + id(num_vertices()) + " vertices",
          "surface");
    }
    for (std::int32_t v = 0; v < num_vertices(); ++v) {
      const Eigen::Vector3d at = input_.surface.col(v);
      if (!at.allFinite() || at.cwiseAbs().maxCoeff() > kMaxRestCoordinate) {
        return invalid_argument("MESH_OUT_OF_RANGE",
                                names_.vertex(v) + " of the rest surface is not within 1e4 m of the origin", "surface");
      }
    }
    return check_regions();
  }

  Status check_regions() {
    const auto num_regions = static_cast<std::int64_t>(input_.regions.size());
    if (num_regions != 0 && num_regions != num_triangles()) {
      return invalid_argument("MESH_REGIONS", id(num_regions) + " regions for " + id(num_triangles()) + " triangles",
                              "regions");
    }
    for (const std::int32_t region : input_.regions) {
      if (region < 0) return invalid_argument("MESH_REGIONS", "region " + id(region) + " is negative", "regions");
    }
    return Nothing{};
  }

  // Rounds positions to lattice points. Vertices at the same lattice point share a mesh point.
  Status quantise() {
    const Eigen::AlignedBox2d box(input_.rest.rowwise().minCoeff(), input_.rest.rowwise().maxCoeff());
    if (box.sizes().maxCoeff() < 1e-9) {
      return invalid_argument("MESH_DEGENERATE_TRIANGLE", "the sheet is smaller than 1e-9 m", "rest");
    }
    data_.lattice = Lattice::for_bounds(box);
    std::vector<std::pair<LatticePoint, VertexId>> order;
    order.reserve(static_cast<std::size_t>(num_vertices()));
    for (VertexId v = 0; v < num_vertices(); ++v) order.emplace_back(data_.lattice.nearest(input_.rest.col(v)), v);
    std::sort(order.begin(), order.end());
    std::vector<VertexId> first_at(order.size());  // the lowest vertex at the same place
    for (std::size_t i = 0; i < order.size(); ++i) {
      const bool is_same = i > 0 && order[i].first == order[i - 1].first;
      first_at[order[i].second] = is_same ? first_at[order[i - 1].second] : order[i].second;
    }
    std::vector<LatticePoint> at(order.size());
    for (const auto& [position, v] : order) at[v] = position;
    for (VertexId v = 0; v < num_vertices(); ++v) {
      if (first_at[v] == v) {
        data_.vertices.push_back({static_cast<PointId>(data_.points.size()), kNone});
        data_.points.push_back({at[v], kNone});
      } else {
        data_.vertices.push_back({data_.vertices[first_at[v]].point, kNone});
      }
    }
    return Nothing{};
  }

  // Lists the sides of all triangles, sorted by their two ends and then by triangle. `by_point`: ends are points, else
  // vertices.
  [[nodiscard]] std::vector<Side> sorted_sides(bool by_point) const {
    std::vector<Side> sides;
    sides.reserve(3 * data_.triangles.size());
    for (TriangleId t = 0; t < num_triangles(); ++t) {
      interruption_point();
      const TriangleRecord& r = data_.triangles[t];
      const std::array<std::int32_t, 3>& ends = by_point ? r.points : r.vertices;
      for (int k = 0; k < 3; ++k) sides.push_back({ends[next_corner(k)], ends[previous_corner(k)], t, k});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return a.ends() != b.ends() ? a.ends() < b.ends()
                                  : std::pair(a.triangle, a.corner) < std::pair(b.triangle, b.corner);
    });
    return sides;
  }

  // Takes over the triangles, and reverses components that are clockwise throughout.
  Status orient() {
    std::vector<int> sign(static_cast<std::size_t>(num_triangles()));
    for (TriangleId t = 0; t < num_triangles(); ++t) {
      interruption_point();
      TriangleRecord r;
      for (int k = 0; k < 3; ++k) {
        r.vertices[k] = input_.triangles(k, t);
        r.points[k] = data_.vertices[r.vertices[k]].point;
      }
      r.region = input_.regions.empty() ? 0 : input_.regions[t];
      data_.triangles.push_back(r);
      const auto at = [&](int k) { return data_.points[r.points[k]].at; };
      sign[t] = orient2d(at(0), at(1), at(2));
      if (flatness(at(0), at(1), at(2)) < kMinFlatness) {
        return invalid_argument(
            "MESH_DEGENERATE_TRIANGLE",
            names_.triangle(t) +
                " is a line, or its height is below a millionth of its longest edge; merge the vertices "
                "that lie close together, or flip that edge",
            "triangles");
      }
    }
    const std::vector<Side> sides = sorted_sides(false);
    for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
      for (j = i; j < sides.size() && sides[j].ends() == sides[i].ends();) ++j;
      const auto edge = [&] { return names_.edge(sides[i].ends().first, sides[i].ends().second); };
      if (j - i > 2) {
        return invalid_argument("MESH_NON_MANIFOLD_EDGE",
                                edge() + " has " + id(static_cast<std::int64_t>(j - i)) + " triangles, such as " +
                                    id(sides[i].triangle) + ", " + id(sides[i + 1].triangle) + ", " +
                                    id(sides[i + 2].triangle),
                                "triangles");
      }
      if (j - i == 1) continue;
      const TriangleId t = sides[i].triangle, u = sides[i + 1].triangle;
      if (sides[i].from == sides[i + 1].from || sign[t] != sign[u]) {
        return invalid_argument(
            "MESH_INCONSISTENT_ORIENTATION",
            names_.triangles(std::array{t, u}) + " at " + edge() + " have opposite orientations, or fold over it",
            "triangles");
      }
    }
    for (TriangleId t = 0; t < num_triangles(); ++t) {  // neighbours have equal signs, so this reverses whole
                                                        // components
      if (sign[t] > 0) continue;
      std::swap(data_.triangles[t].points[1], data_.triangles[t].points[2]);
      std::swap(data_.triangles[t].vertices[1], data_.triangles[t].vertices[2]);
    }
    return Nothing{};
  }

  // Finds the adjacency in the welded mesh. The sheet is cut where the vertices of two sides differ though their points
  // agree.
  Status join_triangles() {
    const std::vector<Side> sides = sorted_sides(true);
    for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
      for (j = i; j < sides.size() && sides[j].ends() == sides[i].ends();) ++j;
      const Side& a = sides[i];
      if (j - i == 1) {
        border_.push_back({a.from, a.to, a.triangle, a.corner});
        continue;
      }
      const Side& b = sides[i + 1];
      if (j - i > 2 || a.from == b.from) {
        return invalid_argument("MESH_OVERLAP",
                                names_.triangles(std::array{a.triangle, b.triangle}) + " overlap along a common edge",
                                "triangles");
      }
      TriangleRecord& ra = data_.triangles[a.triangle];
      TriangleRecord& rb = data_.triangles[b.triangle];
      ra.neighbours[a.corner] = b.triangle;
      rb.neighbours[b.corner] = a.triangle;
      const bool is_whole = ra.vertices[next_corner(a.corner)] == rb.vertices[previous_corner(b.corner)] &&
                            ra.vertices[previous_corner(a.corner)] == rb.vertices[next_corner(b.corner)];
      if (!is_whole) ra.locks[a.corner] = rb.locks[b.corner] = kLockCut;
    }
    std::sort(border_.begin(), border_.end(), [](const BorderSide& a, const BorderSide& b) {
      return std::pair(a.triangle, a.corner) < std::pair(b.triangle, b.corner);
    });
    return Nothing{};
  }

  // Checks that the triangles around each vertex form one fan.
  Status check_vertices() {
    std::vector<std::int32_t> num_corners(data_.vertices.size(), 0);
    for (TriangleId t = num_triangles() - 1; t >= 0; --t) {
      for (const VertexId v : data_.triangles[t].vertices) {
        ++num_corners[v];
        data_.vertices[v].triangle = t;
      }
    }
    const TriangleMesh sheet(data_);
    std::vector<TriangleId> ring;
    for (VertexId v = 0; v < num_vertices(); ++v) {
      sheet.triangles_around(v, ring);
      if (static_cast<std::int32_t>(ring.size()) == num_corners[v]) continue;
      return invalid_argument("MESH_NON_MANIFOLD_VERTEX",
                              "triangles meet at " + names_.vertex(v) + " without a common edge; duplicate the vertex",
                              "triangles");
    }
    return Nothing{};
  }

  Status curve() {
    return input_.surface.cols() == 0 ? Status(Nothing{}) : make_facets(input_.surface, data_, names_);
  }

  void label_pieces() {
    std::vector<TriangleId> stack;
    for (TriangleId first = 0; first < num_triangles(); ++first) {
      if (data_.triangles[first].piece != kNone) continue;
      const std::int32_t piece = data_.num_pieces++;
      data_.triangles[first].piece = piece;
      stack.push_back(first);
      while (!stack.empty()) {
        const TriangleRecord r = data_.triangles[stack.back()];
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
          if (r.locks[k] != 0 || data_.triangles[r.neighbours[k]].piece != kNone) continue;
          data_.triangles[r.neighbours[k]].piece = piece;
          stack.push_back(r.neighbours[k]);
        }
      }
    }
  }

  void anchor() {
    for (auto t = static_cast<TriangleId>(data_.triangles.size()) - 1; t >= 0; --t) {
      for (const PointId p : data_.triangles[t].points) data_.points[p].triangle = t;
    }
  }

  void measure() {
    data_.bounds.setEmpty();
    for (const VertexRecord& v : data_.vertices) {
      data_.bounds.extend(data_.lattice.position(data_.points[v.point].at));
    }
    const std::span<const TriangleRecord> solid(data_.triangles.data(), static_cast<std::size_t>(num_triangles()));
    data_.lengths = EdgeLengths::of(solid, data_.points, data_.lattice, data_.bounds);
  }

  const IndexedMesh& input_;
  const ElementNames& names_;
  MeshData data_;
  std::vector<BorderSide> border_;
};

// Computes material coordinates for a surface without any. Tries the conformal map first, then the convex one, which
// never overlaps.
Result<TriangleMesh> import_surface(const IndexedMesh& input, const ElementNames& names) {
  IndexedMesh with_rest = input;
  with_rest.rest = Eigen::Matrix2Xd::Zero(2, input.surface.cols());  // the checks below do not depend on it
  KERF_TRY(SheetImport(with_rest, names).check());
  const auto import_flattened = [&](Flattening method) -> Result<TriangleMesh> {
    KERF_TRY_ASSIGN(with_rest.rest, flatten(input.surface, input.triangles, method, names));
    return SheetImport(with_rest, names).run();
  };
  Result<TriangleMesh> conformal = import_flattened(Flattening::kConformal);
  return conformal.ok() ? std::move(conformal) : import_flattened(Flattening::kConvex);
}

}  // namespace

Result<TriangleMesh> import_mesh(const IndexedMesh& input, const ElementNames& names) {
  if (input.surface.cols() == 0 || input.rest.cols() > 0) return SheetImport(input, names).run();
  return import_surface(input, names);
}

}  // namespace kerf::mesh
