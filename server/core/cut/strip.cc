#include "server/core/cut/strip.h"

#include <algorithm>
#include <unordered_set>

#include <Eigen/Geometry>

#include "server/base/check.h"
#include "server/core/cut/outline.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::next_corner;
using mesh::PointId;
using mesh::previous_corner;
using mesh::TriangleId;
using mesh::TriangleMesh;

namespace {

std::uint64_t key(PointId low, PointId high) {
  return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint64_t>(high);
}

// Grows the strip from triangles known to be in it.
class StripGrowth {
 public:
  StripGrowth(const TriangleMesh& mesh, const OutlineEdges& outline_edges)
      : mesh_(mesh), outline_edges_(outline_edges) {}

  void add(TriangleId t) {
    if (t == kNone || !mesh_.is_solid(t) || !seen_.insert(t).second) return;
    strip_.push_back(t);
    area_ += mesh_.material_area(t);
  }
  // Returns false if the area becomes larger than max_area (m^2).
  bool grow(double max_area) {
    while (next_ < strip_.size()) {
      if (area_ > max_area) return false;
      const TriangleId t = strip_[next_++];
      for (int k = 0; k < 3; ++k) {
        if (outline_edges_.step(mesh_.points(t)[next_corner(k)], mesh_.points(t)[previous_corner(k)]) != 0) continue;
        add(mesh_.welded_neighbour(t, k));
      }
    }
    return area_ <= max_area;
  }
  [[nodiscard]] std::vector<TriangleId> triangles() const {
    std::vector<TriangleId> sorted = strip_;
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  }

 private:
  const TriangleMesh& mesh_;
  const OutlineEdges& outline_edges_;
  std::vector<TriangleId> strip_;
  std::unordered_set<TriangleId> seen_;  // looked up, never iterated
  std::size_t next_ = 0;
  double area_ = 0.0;  // m^2
};

// Returns one triangle of each piece whose number is not in `touched`.
std::vector<TriangleId> representatives(const TriangleMesh& mesh, const std::vector<bool>& touched) {
  std::vector<bool> done = touched;
  std::vector<TriangleId> found;
  auto missing = std::count(done.begin(), done.end(), false);
  for (TriangleId t = 0; missing > 0 && t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t) || done[static_cast<std::size_t>(mesh.piece(t))]) continue;
    done[static_cast<std::size_t>(mesh.piece(t))] = true;
    found.push_back(t);
    --missing;
  }
  return found;
}

}  // namespace

void OutlineEdges::change(PointId p, PointId q, std::int32_t step) {
  if (step == 0) return;
  steps_[key(std::min(p, q), std::max(p, q))] += p < q ? step : -step;
}

std::int32_t OutlineEdges::step(PointId p, PointId q) const {
  const auto found = steps_.find(key(std::min(p, q), std::max(p, q)));
  if (found == steps_.end()) return 0;
  return p < q ? found->second : -found->second;
}

void OutlineEdges::split(PointId p, PointId q, PointId m) {
  const std::int32_t step = this->step(p, q);
  if (step == 0) return;
  steps_.erase(key(std::min(p, q), std::max(p, q)));
  change(p, m, step);
  change(m, q, step);
}

std::vector<OutlineEdges::Edge> OutlineEdges::edges() const {
  std::vector<std::uint64_t> keys;
  for (const auto& [key, step] : steps_) {
    if (step != 0) keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<Edge> edges;
  edges.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    const auto low = static_cast<PointId>(key >> 32);
    const auto high = static_cast<PointId>(key & 0xffffffffU);
    edges.push_back(steps_.at(key) > 0 ? Edge{low, high} : Edge{high, low});
  }
  return edges;
}

Result<std::vector<TriangleId>> strip_triangles(const TriangleMesh& mesh, const OutlineEdges& outline_edges,
                                                const std::vector<Stroke>& outline, const std::optional<Box>& room,
                                                double max_area_m2) {
  StripGrowth growth(mesh, outline_edges);
  std::vector<bool> touched(static_cast<std::size_t>(mesh.num_pieces()), false);
  for (const auto& [from, to] : outline_edges.edges()) {
    int corner = 0;
    const TriangleId left = mesh.find_edge(from, to, corner);
    KERF_CHECK(left != kNone, "an edge that the outline was laid on is there until it is split");
    const TriangleId right = mesh.welded_neighbour(left, corner);
    for (const TriangleId t : {left, right}) {
      if (mesh.is_solid(t)) touched[static_cast<std::size_t>(mesh.piece(t))] = true;
    }
    growth.add(left);
  }
  bool fits = growth.grow(max_area_m2);
  Eigen::AlignedBox2d box;
  for (const Stroke& stroke : outline) {
    for (const Eigen::Vector2d& point : stroke.points) box.extend(point);
  }
  for (const TriangleId t : representatives(mesh, touched)) {
    const auto& [a, b, c] = mesh.points(t);
    const Eigen::Vector2d centre = (mesh.point_position(a) + mesh.point_position(b) + mesh.point_position(c)) / 3.0;
    if (room && !room->contains(centre)) continue;
    if (box.contains(centre) && contains(outline, centre)) growth.add(t);
  }
  fits = fits && growth.grow(max_area_m2);
  if (!fits) {
    return failed_precondition(
        "CUT_NOT_REPRESENTABLE",
        "the two sides of the strip could not be distinguished between older lips; shift the curve slightly",
        "cut.curve");
  }
  std::vector<TriangleId> strip = growth.triangles();
  if (static_cast<std::int32_t>(strip.size()) == mesh.num_solid_triangles()) {
    return failed_precondition("STRIP_COVERS_SHEET",
                               "the strip would remove the whole sheet; make it narrower, or the curve shorter",
                               "cut.width_m");
  }
  return strip;
}

}  // namespace kerf::cut
