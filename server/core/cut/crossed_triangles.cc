#include "server/core/cut/crossed_triangles.h"

#include <algorithm>
#include <vector>

#include "server/base/check.h"
#include "server/base/sort_unique.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::next_corner;
using mesh::previous_corner;
using mesh::TriangleId;

namespace {

constexpr int kMaxCrossings = 1'000'000;  // most triangles that one segment may run through

// Appends the solid triangles along the segment ab, from `t`, which holds a, up to the one that holds b, and returns
// that one. Leaves a triangle by the edge that separates it from b and that line ab passes. At an exact point it may be
// either edge there.
TriangleId append_crossed(const mesh::TriangleMesh& mesh, TriangleId t, const LatticePoint& a, const LatticePoint& b,
                          std::vector<TriangleId>& crossed) {
  TriangleId previous = kNone;
  for (int step = 0; step < kMaxCrossings; ++step) {
    if (mesh.is_solid(t)) crossed.push_back(t);
    TriangleId next = kNone;
    for (int k = 0; k < 3 && next == kNone; ++k) {
      const LatticePoint& right = mesh.at(mesh.points(t)[next_corner(k)]);
      const LatticePoint& left = mesh.at(mesh.points(t)[previous_corner(k)]);
      if (mesh.welded_neighbour(t, k) == previous || mesh::orient2d(right, left, b) >= 0) continue;
      if (mesh::orient2d(a, b, right) <= 0 && mesh::orient2d(a, b, left) >= 0) next = mesh.welded_neighbour(t, k);
    }
    if (next == kNone) break;
    previous = t;
    t = next;
  }
  return t;
}

}  // namespace

std::vector<TriangleId> crossed_triangles(const mesh::TriangleMesh& mesh, std::span<const Stroke> strokes) {
  std::vector<TriangleId> crossed;
  TriangleId t = kNone;
  for (const Stroke& stroke : strokes) {
    LatticePoint a = mesh.lattice().nearest(stroke.points.front());
    t = mesh.locate(a, t).triangle;
    KERF_CHECK(t != kNone, "a clipped path stays inside the domain");
    for (std::size_t i = 1; i < stroke.points.size(); ++i) {
      const LatticePoint b = mesh.lattice().nearest(stroke.points[i]);
      t = append_crossed(mesh, t, a, b, crossed);
      a = b;
    }
  }
  sort_unique(crossed);
  return crossed;
}

}  // namespace kerf::cut
