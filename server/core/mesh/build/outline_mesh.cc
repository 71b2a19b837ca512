#include "server/core/mesh/build/outline_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "server/base/check.h"
#include "server/base/interruption.h"
#include "server/core/mesh/build/front_fill.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/build/outline_border.h"
#include "server/core/mesh/refine/delaunay.h"
#include "server/core/mesh/refine/relaxation.h"
#include "server/core/mesh/refine/size_field.h"

namespace kerf::mesh {
namespace {

using Eigen::Vector2d;

constexpr double kDefaultEdges = 32.0;     // edges along the larger side of the border, if no edge length is given
constexpr double kGradingOfBorder = 0.25;  // -; growth of the edge length away from short edges of contours
// An edge of a contour is short if its length is below this fraction of the size requested there. -
constexpr double kAsAsked = 0.8;
constexpr double kWellShaped = 0.96;      // -; `well_shaped` of relax()
constexpr double kEstimateMargin = 1.15;  // factor on max_vertices; outlines with a higher estimate are refused at once
                                          // -
constexpr double kAreaOfVertex = 0.8660254037844386;  // area over squared edge length: two triangles -
// Most times that the inside is filled. It is filled again if the border needs more vertices and the triangles beside
// it leave no room for them.
constexpr int kMaxRounds = 5;
constexpr double kShortest = 4096.0;  // lattice units; triangles with a shorter edge are not refined

double size_of(const Eigen::AlignedBox2d& box) {
  return box.sizes().maxCoeff();
}

Error too_fine(std::int32_t max_vertices) {
  return resource_exhausted(
      "OUTLINE_TOO_FINE",
      "the outline would need more than " + std::to_string(max_vertices) +
          " vertices; allow longer edges, let them grow faster, or widen the narrow places between its curves",
      "edge_length");
}

// Estimates how many vertices a mesh of the wanted sizes needs; stops once the total is above `limit`.
class VertexEstimate {
 public:
  VertexEstimate(const SizeField& sizes, double limit) : sizes_(sizes), limit_(limit) {}

  void add(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    interruption_point();
    if (total_ > limit_) return;
    const double doubled_area = std::abs((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
    const double ab = (b - a).norm(), bc = (c - b).norm(), ca = (a - c).norm();
    const double size = sizes_.at((a + b + c) / 3.0);
    if (doubled_area < size * size || sizes_.steepest_growth() * std::max({ab, bc, ca}) < 0.5 * size) {
      total_ += 0.5 * doubled_area / (kAreaOfVertex * size * size);
      return;
    }
    if (ab >= bc && ab >= ca) return add_halves(a, b, c);
    return bc >= ca ? add_halves(b, c, a) : add_halves(c, a, b);
  }
  [[nodiscard]] double total() const { return total_; }

 private:
  void add_halves(const Vector2d& a, const Vector2d& b, const Vector2d& apex) {
    const Vector2d middle = 0.5 * (a + b);
    add(a, middle, apex);
    add(middle, b, apex);
  }

  const SizeField& sizes_;
  double limit_;
  double total_ = 0.0;
};

class OutlineMesher {
 public:
  OutlineMesher(const OutlineConfig& config, OutlineBorder border)
      : config_(config), border_(std::move(border)), edge_length_(config.edge_length) {
    if (edge_length_ == 0.0) edge_length_ = size_of(border_.bounds()) / kDefaultEdges;
  }

  Result<TriangleMesh> run() {
    KERF_TRY(check_lengths());
    // Estimates the vertices that the longest edges would take, before any vertex is made.
    const double area = border_.area();
    if (area / (kAreaOfVertex * edge_length_ * edge_length_) > kEstimateMargin * config_.max_vertices ||
        !border_.divide(sizes(), config_.max_vertices)) {
      return too_fine(config_.max_vertices);
    }
    KERF_TRY_ASSIGN(TriangleMesh coarse, triangulate());
    {
      MeshEditor editor(coarse);
      border_.follow(coarse.lattice());
      if (!refine_angles(editor)) return too_fine(config_.max_vertices);
    }
    for (int round = 1;; ++round) {
      if (!border_.renew(config_.max_vertices)) return too_fine(config_.max_vertices);
      KERF_TRY_ASSIGN(TriangleMesh mesh, triangulate());
      MeshEditor editor(mesh);
      if (!fill(editor)) return too_fine(config_.max_vertices);
      if (!border_.has_missed() || round == kMaxRounds) return collect(mesh);
    }
  }

 private:
  [[nodiscard]] Status check_lengths() const {
    KERF_TRY(check_length(edge_length_, "edge_length"));
    for (const OutlineSize& size : config_.sizes) {
      KERF_TRY(check_length(size.length, size.field));
    }
    return Nothing{};
  }

  [[nodiscard]] Status check_length(double length, const std::string& field) const {
    const double side = size_of(border_.bounds());
    if (length >= kMinOutlineEdge * side) return Nothing{};
    return invalid_argument(
        "OUTLINE_EDGE_LENGTH",
        "edges must be at least 1e-9 of the outline's larger side, which is " + std::to_string(side) + " m", field);
  }

  [[nodiscard]] std::vector<SizeSource> requested_sources() const {
    std::vector<SizeSource> sources;
    for (const OutlineSize& size : config_.sizes) {
      for (std::size_t i = 0; i + 1 < size.points.size(); ++i) {
        sources.push_back({size.points[i], size.points[i + 1], size.length, size.growth});
      }
      if (size.points.size() == 1) sources.push_back({size.points[0], size.points[0], size.length, size.growth});
    }
    return sources;
  }

  [[nodiscard]] SizeField sizes() const { return {edge_length_, requested_sources()}; }

  // Returns the sizes for the inside: the requested ones, reduced around edges of contours that are shorter than
  // requested.
  [[nodiscard]] SizeField sizes_inside() const {
    const SizeField asked = sizes();
    std::vector<SizeSource> sources = requested_sources();
    for (std::size_t v = 0; v < border_.vertices().size(); ++v) {
      const Vector2d a = border_.lattice().position(border_.vertices()[v].at);
      const auto next = static_cast<std::size_t>(border_.next(static_cast<std::int32_t>(v)));
      const Vector2d b = border_.lattice().position(border_.vertices()[next].at);
      const double length = (b - a).norm();
      if (length < kAsAsked * asked.at(0.5 * (a + b))) sources.push_back({a, b, length, kGradingOfBorder});
    }
    return {edge_length_, std::move(sources)};
  }

  // Makes a mesh of the inside with the vertices of the contours only: the constrained Delaunay triangulation.
  Result<TriangleMesh> triangulate() {
    std::vector<LatticePoint> points;
    for (const OutlineBorder::Vertex& vertex : border_.vertices()) points.push_back(vertex.at);
    TriangleMesh domain = make_empty_domain(border_.lattice());
    MeshEditor editor(domain);
    const std::vector<PointId> inserted = insert_delaunay(editor, points);
    vertex_at_.assign(points.size() + 4, kNone);
    for (std::size_t v = 0; v < points.size(); ++v) vertex_at_[inserted[v]] = static_cast<std::int32_t>(v);
    for (std::size_t v = 0; v < points.size(); ++v) {
      const auto next = static_cast<std::size_t>(border_.next(static_cast<std::int32_t>(v)));
      const Recovery made = editor.recover_edge(inserted[v], inserted[next], kLockOriginal);
      if (made.status == Recovery::Status::kRecovered) continue;
      const std::string& field = border_.field(border_.vertices()[v].contour);
      return invalid_argument("OUTLINE_CROSSES", field + " comes too close to itself or to another", field);
    }
    KERF_TRY_ASSIGN(const std::vector<TriangleId> inside, find_inside(domain));
    IndexedMesh indexed;
    indexed.rest.resize(2, static_cast<Eigen::Index>(points.size()));
    for (std::size_t v = 0; v < points.size(); ++v) {
      indexed.rest.col(static_cast<Eigen::Index>(v)) = border_.lattice().position(points[v]);
    }
    indexed.triangles.resize(3, static_cast<Eigen::Index>(inside.size()));
    for (std::size_t i = 0; i < inside.size(); ++i) {
      const std::array<PointId, 3>& corners = domain.points(inside[i]);
      indexed.triangles.col(static_cast<Eigen::Index>(i)) =
          Eigen::Vector3i(vertex_at_[corners[0]], vertex_at_[corners[1]], vertex_at_[corners[2]]);
    }
    return import_mesh(indexed);
  }

  // Returns the triangles inside an odd number of contours. Floods the domain from outside, one level of nested
  // contours after the other.
  [[nodiscard]] Result<std::vector<TriangleId>> find_inside(const TriangleMesh& domain) const {
    std::vector<TriangleId> inside, level{domain.triangle_at_point(0)}, beyond;
    std::vector<bool> is_reached(static_cast<std::size_t>(domain.num_triangle_slots()));
    for (int depth = 0; !level.empty(); ++depth) {
      beyond.clear();
      while (!level.empty()) {
        const TriangleId t = level.back();
        level.pop_back();
        if (is_reached[t]) continue;
        is_reached[t] = true;
        if (depth % 2 == 1) inside.push_back(t);
        for (int k = 0; k < 3; ++k) {
          const TriangleId u = domain.welded_neighbour(t, k);
          if (u == kNone || is_reached[u]) continue;
          if ((domain.locks(t, k) & kLockOriginal) == 0) {
            level.push_back(u);
            continue;
          }
          const std::int32_t contour = border_.vertices()[vertex_at_[domain.points(t)[next_corner(k)]]].contour;
          KERF_TRY(check_nesting(contour, depth));
          beyond.push_back(u);
        }
      }
      level.swap(beyond);
    }
    return inside;
  }

  // Refuses a hole at a wrong level: it must lie inside an odd number of contours. `depth`: number of contours around
  // it.
  [[nodiscard]] Status check_nesting(std::int32_t contour, int depth) const {
    const std::string& field = border_.field(contour);
    const bool is_border = contour < static_cast<std::int32_t>(config_.num_border_contours);
    if (is_border || depth % 2 == 1) return Nothing{};
    return invalid_argument(
        "OUTLINE_NESTING",
        field + (depth == 0 ? " lies outside the border, or around it" : " lies inside another hole"), field);
  }

  // Refines until no angle is too small, except where the outline forces one. Returns false if there would be too many
  // vertices.
  bool refine_angles(MeshEditor& editor) {
    RefinementConfig refinement;
    refinement.min_angle_deg = config_.min_angle_deg;
    refinement.length_floor = kShortest;
    refinement.max_insertions = config_.max_vertices - editor.mesh().num_points() + kDomainCorners;
    refinement.lengths = &editor.mesh().edge_lengths();
    refinement.border = &border_;
    std::vector<TriangleId> all;
    for (TriangleId t = 0; t < editor.mesh().num_triangle_slots(); ++t) {
      if (editor.mesh().is_solid(t)) all.push_back(t);
    }
    return !refine(editor, all, refinement).stopped && !editor.budget_exhausted();
  }

  // Fills the inside with triangles of the wanted sizes, relaxes and refines them. Returns false if there would be too
  // many vertices.
  bool fill(MeshEditor& editor) {
    const TriangleMesh& mesh = editor.mesh();
    const SizeField wanted = sizes_inside();
    const double limit = kEstimateMargin * config_.max_vertices;
    VertexEstimate estimate(wanted, limit);
    for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
      if (!mesh.is_solid(t)) continue;
      const std::array<PointId, 3>& p = mesh.points(t);
      estimate.add(mesh.point_position(p[0]), mesh.point_position(p[1]), mesh.point_position(p[2]));
    }
    if (estimate.total() + 0.5 * mesh.num_vertices() > limit) return false;
    if (!fill_from_border(editor, wanted, config_.max_vertices - mesh.num_vertices())) return false;
    relax_inside(editor);
    border_.follow(mesh.lattice());
    return refine_angles(editor);
  }

  static void relax_inside(MeshEditor& editor) {
    std::vector<PointId> inside;
    for (PointId p = 0; p < editor.mesh().num_points(); ++p) {
      if (editor.is_new(p)) inside.push_back(p);
    }
    relax(editor, inside, {}, kWellShaped);
  }

  // Makes a mesh of the solid part alone; vertices near each other have near numbers.
  static Result<TriangleMesh> collect(const TriangleMesh& mesh) {
    std::vector<bool> is_solid(static_cast<std::size_t>(mesh.num_points()));
    std::vector<TriangleId> solid;
    for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
      if (!mesh.is_solid(t)) continue;
      solid.push_back(t);
      for (const PointId p : mesh.points(t)) is_solid[p] = true;
    }
    std::vector<std::pair<std::uint64_t, PointId>> order;
    for (PointId p = 0; p < mesh.num_points(); ++p) {
      if (is_solid[p]) order.emplace_back(hilbert_index(mesh.at(p)), p);
    }
    std::sort(order.begin(), order.end());
    std::vector<VertexId> vertex(static_cast<std::size_t>(mesh.num_points()), kNone);
    IndexedMesh indexed;
    indexed.rest.resize(2, static_cast<Eigen::Index>(order.size()));
    for (std::size_t v = 0; v < order.size(); ++v) {
      vertex[order[v].second] = static_cast<VertexId>(v);
      indexed.rest.col(static_cast<Eigen::Index>(v)) = mesh.point_position(order[v].second);
    }
    std::vector<std::array<VertexId, 3>> triangles;
    for (const TriangleId t : solid) {
      std::array<VertexId, 3> corners{};
      for (int k = 0; k < 3; ++k) corners[k] = vertex[mesh.points(t)[k]];
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      triangles.push_back(corners);
    }
    std::sort(triangles.begin(), triangles.end());
    indexed.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      indexed.triangles.col(static_cast<Eigen::Index>(t)) =
          Eigen::Vector3i(triangles[t][0], triangles[t][1], triangles[t][2]);
    }
    return import_mesh(indexed);
  }

  static constexpr std::int32_t kDomainCorners = 4;

  const OutlineConfig& config_;
  OutlineBorder border_;
  double edge_length_;                   // m
  std::vector<std::int32_t> vertex_at_;  // index into border_.vertices(), by point of the domain triangulated last
};

}  // namespace

Result<TriangleMesh> mesh_outline(const OutlineConfig& config) {
  KERF_CHECK(!config.contours.empty(), "an outline has a border");
  KERF_TRY_ASSIGN(OutlineBorder border, OutlineBorder::make(config.contours));
  return OutlineMesher(config, std::move(border)).run();
}

}  // namespace kerf::mesh
