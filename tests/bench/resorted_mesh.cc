#include "tests/bench/resorted_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "server/base/check.h"

namespace kerf::bench {
namespace {

using mesh::kNone;
using mesh::TriangleId;
using mesh::VertexId;

// Returns the code of a place in the unit square: bits of both coordinates in turn (Morton 1966).
std::uint64_t along_curve(const Eigen::Vector2d& at) {
  constexpr int kBits = 20;
  std::uint64_t code = 0;
  const auto x = static_cast<std::uint64_t>(std::ldexp(std::clamp(at.x(), 0.0, 0.999999), kBits));
  const auto y = static_cast<std::uint64_t>(std::ldexp(std::clamp(at.y(), 0.0, 0.999999), kBits));
  for (int bit = 0; bit < kBits; ++bit) {
    code |= ((x >> bit & 1) << (2 * bit)) | ((y >> bit & 1) << (2 * bit + 1));
  }
  return code;
}

// Places in ascending order of the keys; equal ones stay in order.
template <typename Key>
std::vector<std::int32_t> ranks(const std::vector<Key>& keys) {
  std::vector<std::int32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&keys](std::int32_t a, std::int32_t b) {
    return keys[static_cast<std::size_t>(a)] < keys[static_cast<std::size_t>(b)];
  });
  std::vector<std::int32_t> rank(keys.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    rank[static_cast<std::size_t>(order[i])] = static_cast<std::int32_t>(i);
  return rank;
}

std::vector<VertexId> number_vertices(const mesh::TriangleMesh& mesh, int side, Order order) {
  std::vector<std::pair<double, double>> keys;
  for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector2d at = mesh.rest_position(v);
    const bool is_new = v >= side * side;
    const auto on_curve = static_cast<double>(along_curve(at));
    switch (order) {
      case Order::kSame:
      case Order::kTriangles:
        keys.emplace_back(v, 0.0);
        break;
      case Order::kNewVertices:
        keys.emplace_back(is_new ? side * side : v, on_curve);
        break;
      case Order::kRows:
        // Vertices that a cut has moved stay where they are in their row.
        keys.emplace_back(is_new ? std::round(at.y() * (side - 1)) : v / side, is_new ? at.x() * (side - 1) : v % side);
        break;
      case Order::kCurve:
        keys.emplace_back(on_curve, 0.0);
        break;
    }
  }
  return ranks(keys);
}

}  // namespace

Numbering number(const mesh::TriangleMesh& mesh, int side, Order order) {
  Numbering numbering;
  numbering.vertices = number_vertices(mesh, side, order);
  std::vector<std::uint64_t> keys;
  for (TriangleId slot = 0; slot < mesh.num_triangle_slots(); ++slot) {
    if (order == Order::kSame || !mesh.is_solid(slot)) {
      keys.push_back(std::uint64_t{1} << 62);  // stay in order, the void last
      if (order == Order::kSame) keys.back() = static_cast<std::uint64_t>(slot);
      continue;
    }
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    VertexId lowest = mesh.num_vertices();
    for (const VertexId v : mesh.vertices(slot)) {
      middle += mesh.rest_position(v) / 3.0;
      lowest = std::min(lowest, numbering.vertices[static_cast<std::size_t>(v)]);
    }
    const bool is_by_vertex = order == Order::kRows || order == Order::kCurve;
    keys.push_back(is_by_vertex ? static_cast<std::uint64_t>(lowest) : along_curve(middle));
  }
  numbering.slots = ranks(keys);
  return numbering;
}

mesh::TriangleMesh renumbered(const mesh::TriangleMesh& mesh, const Numbering& numbering) {
  const auto vertex = [&](VertexId v) { return v == kNone ? kNone : numbering.vertices[static_cast<std::size_t>(v)]; };
  const auto slot = [&](TriangleId t) { return t == kNone ? kNone : numbering.slots[static_cast<std::size_t>(t)]; };
  mesh::MeshData data = mesh.data();
  for (mesh::PointRecord& point : data.points) point.triangle = slot(point.triangle);
  for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const mesh::VertexRecord& from = mesh.data().vertices[static_cast<std::size_t>(v)];
    data.vertices[static_cast<std::size_t>(vertex(v))] = {from.point, slot(from.triangle)};
  }
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    mesh::TriangleRecord to = mesh.data().triangles[static_cast<std::size_t>(t)];
    for (VertexId& v : to.vertices) v = vertex(v);
    for (TriangleId& neighbour : to.neighbours) neighbour = slot(neighbour);
    data.triangles[static_cast<std::size_t>(slot(t))] = to;
  }
  mesh::TriangleMesh result(std::move(data));
  KERF_CHECK(!result.find_violation(), "a mesh stays valid whatever its numbers");
  return result;
}

}  // namespace kerf::bench
