#include "server/core/mesh/build/void_fill.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "server/base/check.h"
#include "server/base/sort_unique.h"
#include "server/core/mesh/refine/delaunay.h"

namespace kerf::mesh {
namespace {

constexpr int kUnvisited = -1'000'000;

class VoidFill {
 public:
  VoidFill(MeshData& data, std::span<const BorderSide> border, const ElementNames& names)
      : data_(data), border_(border), names_(names), domain_(make_empty_domain(data.lattice)) {
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(border_.size()); ++i)
      by_ends_.push_back({key(border_[i]), i});
    std::sort(by_ends_.begin(), by_ends_.end());
  }

  Status run() {
    KERF_TRY(triangulate_border());
    KERF_TRY(compute_winding());
    append_void();
    return Nothing{};
  }

 private:
  using Ends = std::pair<PointId, PointId>;

  static Ends key(const BorderSide& side) { return {side.from, side.to}; }

  // Returns the border side from -> to (points of the sheet), or null.
  [[nodiscard]] const BorderSide* find_side(PointId from, PointId to) const {
    const auto at = std::lower_bound(by_ends_.begin(), by_ends_.end(), std::pair<Ends, std::int32_t>{{from, to}, 0});
    return at != by_ends_.end() && at->first == Ends{from, to} ? &border_[at->second] : nullptr;
  }

  [[nodiscard]] static Error overlap(const std::string& what) {
    return invalid_argument("MESH_OVERLAP", what + "; the rest shape of a sheet may not overlap itself", "triangles");
  }

  // Names a vertex at a point of the sheet.
  [[nodiscard]] std::string point_name(PointId point) const {
    const auto at = std::find_if(data_.vertices.begin(), data_.vertices.end(),
                                 [point](const VertexRecord& vertex) { return vertex.point == point; });
    return names_.vertex(static_cast<VertexId>(at - data_.vertices.begin()));
  }

  Status triangulate_border() {
    std::vector<PointId> used;
    for (const BorderSide& side : border_) used.insert(used.end(), {side.from, side.to});
    sort_unique(used);
    std::vector<LatticePoint> positions;
    positions.reserve(used.size());
    for (const PointId p : used) positions.push_back(data_.points[p].at);
    MeshEditor editor(domain_);
    const std::vector<PointId> inserted = insert_delaunay(editor, positions);
    sheet_point_.assign(used.size() + 4, kNone);
    domain_point_.assign(data_.points.size(), kNone);
    for (std::size_t i = 0; i < used.size(); ++i) {
      sheet_point_[inserted[i]] = used[i];
      domain_point_[used[i]] = inserted[i];
    }
    for (const BorderSide& side : border_) {
      const Recovery made = editor.recover_edge(domain_point_[side.from], domain_point_[side.to], kLockOriginal);
      if (made.status == Recovery::Status::kRecovered) continue;
      if (made.status == Recovery::Status::kPoint) {
        return overlap(point_name(sheet_point_[made.point]) + " lies inside a border edge of " +
                       names_.triangle(side.triangle));
      }
      KERF_CHECK(made.status == Recovery::Status::kFixedEdge, "recovery of an edge ends");
      const BorderSide& other = *side_of_edge(made.triangle, made.corner);
      return overlap("border edges of " + names_.triangle(side.triangle) + " and " + names_.triangle(other.triangle) +
                     " cross");
    }
    locked_.resize(static_cast<std::size_t>(domain_.num_triangle_slots()));
    for (TriangleId t = 0; t < domain_.num_triangle_slots(); ++t) locked_[t] = domain_.record(t).locks;
    (void)editor.commit();
    return Nothing{};
  }

  // Returns the border side on edge k of domain triangle t, in either direction.
  [[nodiscard]] const BorderSide* side_of_edge(TriangleId t, int k) const {
    const PointId a = sheet_point_[domain_.points(t)[next_corner(k)]];
    const PointId b = sheet_point_[domain_.points(t)[previous_corner(k)]];
    const BorderSide* side = find_side(a, b);
    return side != nullptr ? side : find_side(b, a);
  }

  Status compute_winding() {
    winding_.assign(static_cast<std::size_t>(domain_.num_triangle_slots()), kUnvisited);
    std::vector<TriangleId> stack{domain_.data().points[0].triangle};
    winding_[stack.back()] = 0;
    while (!stack.empty()) {
      const TriangleId t = stack.back();
      stack.pop_back();
      if (winding_[t] != 0 && winding_[t] != 1) return overlap_at(t);
      for (int k = 0; k < 3; ++k) {
        const TriangleId n = domain_.welded_neighbour(t, k);
        if (n == kNone || winding_[n] != kUnvisited) continue;
        winding_[n] = winding_[t];
        if (locked_[t][k] != 0) {
          const PointId a = sheet_point_[domain_.points(t)[next_corner(k)]];
          const PointId b = sheet_point_[domain_.points(t)[previous_corner(k)]];
          winding_[n] += find_side(b, a) != nullptr ? 1 : -1;  // n lies to the left of b -> a
        }
        stack.push_back(n);
      }
    }
    return Nothing{};
  }

  // Names the triangles that cover the middle of domain triangle t.
  [[nodiscard]] Error overlap_at(TriangleId t) const {
    const std::array<PointId, 3>& p = domain_.points(t);
    LatticePoint middle;
    for (const PointId corner : p) {
      middle.x += domain_.at(corner).x / 3;
      middle.y += domain_.at(corner).y / 3;
    }
    std::vector<TriangleId> covering;
    for (TriangleId s = 0; s < static_cast<TriangleId>(data_.triangles.size()) && covering.size() < 8; ++s) {
      const std::array<PointId, 3>& c = data_.triangles[s].points;
      bool is_inside = true;
      for (int k = 0; k < 3; ++k) {
        is_inside = is_inside && orient2d(data_.points[c[k]].at, data_.points[c[next_corner(k)]].at, middle) >= 0;
      }
      if (is_inside) covering.push_back(s);
    }
    return overlap(names_.triangles(covering) + " overlap");
  }

  void append_void() {
    const auto num_solid = static_cast<TriangleId>(data_.triangles.size());
    const auto num_points = static_cast<PointId>(data_.points.size());
    for (PointId p = 0; p < 4; ++p) data_.points.push_back({domain_.at(p), kNone});
    std::vector<TriangleId> slot(winding_.size(), kNone);
    TriangleId next = num_solid;
    for (TriangleId t = 0; t < domain_.num_triangle_slots(); ++t) {
      if (winding_[t] == 0) slot[t] = next++;
    }
    for (TriangleId t = 0; t < domain_.num_triangle_slots(); ++t) {
      if (winding_[t] != 0) continue;
      TriangleRecord record;
      for (int k = 0; k < 3; ++k) {
        const PointId p = domain_.points(t)[k];
        record.points[k] = p < 4 ? num_points + p : sheet_point_[p];
        const TriangleId n = domain_.welded_neighbour(t, k);
        if (locked_[t][k] == 0) {
          record.neighbours[k] = n == kNone ? kNone : slot[n];
          continue;
        }
        const BorderSide& side = *side_of_edge(t, k);
        record.neighbours[k] = side.triangle;
        record.locks[k] = kLockBorder;
        TriangleRecord& solid = data_.triangles[side.triangle];
        solid.neighbours[side.corner] = slot[t];
        solid.locks[side.corner] = kLockBorder;
      }
      data_.triangles.push_back(record);
    }
  }

  MeshData& data_;
  std::span<const BorderSide> border_;
  const ElementNames& names_;
  TriangleMesh domain_;  // the triangulation of the border's points, with its edges
  std::vector<std::pair<Ends, std::int32_t>> by_ends_;
  std::vector<PointId> sheet_point_;   // point of domain_ -> point of the sheet; kNone for the domain's corners
  std::vector<PointId> domain_point_;  // point of the sheet -> point of domain_
  std::vector<std::array<LockBits, 3>> locked_;  // by slot of domain_: which edges are border
  std::vector<int> winding_;                     // winding number of the border around each slot of domain_
};

}  // namespace

Status fill_void(MeshData& data, std::span<const BorderSide> border, const ElementNames& names) {
  return VoidFill(data, border, names).run();
}

}  // namespace kerf::mesh
