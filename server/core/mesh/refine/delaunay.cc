#include "server/core/mesh/refine/delaunay.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "server/base/check.h"
#include "server/base/random.h"

namespace kerf::mesh {

std::uint64_t hilbert_index(const LatticePoint& p) {
  constexpr int kBits = 20;
  auto x = static_cast<std::uint64_t>((p.x + kMaxCoordinate) >> (53 - kBits));
  auto y = static_cast<std::uint64_t>((p.y + kMaxCoordinate) >> (53 - kBits));
  std::uint64_t index = 0;
  for (std::uint64_t side = std::uint64_t{1} << (kBits - 1); side > 0; side >>= 1) {
    const std::uint64_t rx = (x & side) != 0 ? 1 : 0;
    const std::uint64_t ry = (y & side) != 0 ? 1 : 0;
    index += side * side * ((3 * rx) ^ ry);
    if (ry == 0) {  // turn the quadrant so that the curve stays connected
      constexpr std::uint64_t kLast = (std::uint64_t{1} << kBits) - 1;
      if (rx == 1) {
        x = kLast - x;
        y = kLast - y;
      }
      std::swap(x, y);
    }
  }
  return index;
}

namespace {

// Shuffles the points into rounds, each as large as all before it together, and sorts each round along the Hilbert
// curve.
std::vector<std::size_t> insertion_order(std::span<const LatticePoint> points) {
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  SeededRandom random(0x6272696f);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  std::vector<std::pair<std::uint64_t, std::size_t>> keyed;
  for (std::size_t begin = 0, end = std::min<std::size_t>(64, order.size()); begin < order.size();
       begin = end, end = std::min(2 * end, order.size())) {
    keyed.clear();
    for (std::size_t i = begin; i < end; ++i) keyed.emplace_back(hilbert_index(points[order[i]]), order[i]);
    std::sort(keyed.begin(), keyed.end());
    for (std::size_t i = begin; i < end; ++i) order[i] = keyed[i - begin].second;
  }
  return order;
}

}  // namespace

TriangleMesh make_empty_domain(const Lattice& lattice) {
  MeshData data;
  data.lattice = lattice;
  constexpr std::int64_t kHalf = Lattice::kHalfDomain;
  data.points = {{{-kHalf, -kHalf}, 0}, {{kHalf, -kHalf}, 0}, {{kHalf, kHalf}, 0}, {{-kHalf, kHalf}, 1}};
  TriangleRecord below;
  below.points = {0, 1, 2};
  below.neighbours = {kNone, 1, kNone};
  TriangleRecord above;
  above.points = {0, 2, 3};
  above.neighbours = {kNone, kNone, 0};
  data.triangles = {below, above};
  return TriangleMesh(std::move(data));
}

std::vector<PointId> insert_delaunay(MeshEditor& editor, std::span<const LatticePoint> points) {
  std::vector<PointId> ids(points.size(), kNone);
  TriangleId hint = kNone;
  for (const std::size_t i : insertion_order(points)) {
    const PointId p = editor.insert_point(points[i], hint);
    KERF_CHECK(p != kNone, "a point inside a domain without locks can be inserted");
    editor.legalise(p);
    hint = editor.mesh().data().points[p].triangle;
    ids[i] = p;
  }
  return ids;
}

}  // namespace kerf::mesh
