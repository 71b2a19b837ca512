#include "server/core/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/base/check.h"

namespace kerf::mesh {

TriangleMesh::TriangleMesh(MeshData data) : data_(std::move(data)) {
  build_hints();
}

void TriangleMesh::triangles_around(VertexId v, std::vector<TriangleId>& ring) const {
  ring.clear();
  const PointId p = point(v);
  const TriangleId start = triangle_at(v);
  if (start == kNone) return;
  TriangleId first = start;
  for (TriangleId t = start;;) {  // turns clockwise, to the first triangle of an open fan
    t = neighbour(t, previous_corner(corner_of(t, p)));
    if (t == kNone) break;
    first = t;
    if (t == start) break;
  }
  for (TriangleId t = first; t != kNone;) {
    ring.push_back(t);
    t = neighbour(t, next_corner(corner_of(t, p)));
    if (t == first) break;
  }
}

LockBits TriangleMesh::locks_at_point(PointId p) const {
  std::vector<TriangleId> fan;
  fan_around(p, fan);
  LockBits bits = 0;
  for (const TriangleId t : fan) {
    const int corner = corner_of(t, p);
    bits = static_cast<LockBits>(bits | locks(t, next_corner(corner)) | locks(t, previous_corner(corner)));
  }
  return bits;
}

bool TriangleMesh::has_fixed_edge(PointId p) const {
  std::vector<TriangleId> fan;
  fan_around(p, fan);
  return std::any_of(fan.begin(), fan.end(),
                     [&](TriangleId t) { return is_fixed(t, previous_corner(corner_of(t, p))); });
}

void TriangleMesh::fan_around(PointId p, std::vector<TriangleId>& fan) const {
  fan.clear();
  const TriangleId start = data_.points[p].triangle;
  TriangleId first = start;
  if (std::abs(at(p).x) == Lattice::kHalfDomain &&
      std::abs(at(p).y) == Lattice::kHalfDomain) {  // the fan is open at a corner of the domain
    for (TriangleId t = start; t != kNone; t = welded_neighbour(t, previous_corner(corner_of(t, p)))) first = t;
  }
  for (TriangleId t = first; t != kNone;) {
    fan.push_back(t);
    t = welded_neighbour(t, next_corner(corner_of(t, p)));
    if (t == first) break;
  }
}

double TriangleMesh::area(TriangleId t) const {
  const Facet* const on = facet(t);
  return on != nullptr ? on->area_ratio() * material_area(t) : material_area(t);
}

double TriangleMesh::material_area(TriangleId t) const {
  const std::array<PointId, 3>& p = points(t);
  const double spacing = data_.lattice.spacing;
  return 0.5 * spacing * spacing * to_double(doubled_area(at(p[0]), at(p[1]), at(p[2])));
}

Eigen::Matrix2d TriangleMesh::rest_edges(TriangleId t) const {
  const std::array<PointId, 3>& p = points(t);
  const auto edge = [&](PointId to) {
    const LatticePoint& a = at(p[0]);
    const LatticePoint& b = at(to);
    return Eigen::Vector2d(data_.lattice.spacing *
                           Eigen::Vector2d(static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y)));
  };
  Eigen::Matrix2d edges;
  edges << edge(p[1]), edge(p[2]);
  const Facet* const on = facet(t);
  return on != nullptr ? Eigen::Matrix2d(on->stretch() * edges) : edges;
}

bool TriangleMesh::is_in_circle(TriangleId t, const LatticePoint& p) const {
  const std::array<PointId, 3>& corners = points(t);
  const Facet* const on = facet(t);
  if (on == nullptr) return in_circle(at(corners[0]), at(corners[1]), at(corners[2]), p) > 0;
  constexpr double kRounding = 1e-10;  // -; rounding error over the sum of the terms' magnitudes
  const Eigen::Matrix2d stretch = on->stretch();
  std::array<Eigen::Vector2d, 3> offset;
  for (std::size_t k = 0; k < 3; ++k) {
    const LatticePoint& corner = at(corners[k]);
    offset[k] = stretch * Eigen::Vector2d(static_cast<double>(corner.x - p.x), static_cast<double>(corner.y - p.y));
  }
  double sum = 0.0;
  double size = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector2d& a = offset[(k + 1) % 3];
    const Eigen::Vector2d& b = offset[(k + 2) % 3];
    const double lifted = offset[k].squaredNorm();
    sum += lifted * (a.x() * b.y() - a.y() * b.x());
    size += lifted * (std::abs(a.x() * b.y()) + std::abs(a.y() * b.x()));
  }
  return sum > kRounding * size;
}

TriangleId TriangleMesh::find_edge(PointId p, PointId q, int& corner) const {
  const TriangleId start = data_.points[p].triangle;
  for (const bool clockwise : {false, true}) {  // tries clockwise only if the fan is open, at the domain's corners
    TriangleId t = start;
    do {
      const int c = corner_of(t, p);
      if (points(t)[next_corner(c)] == q) {
        corner = previous_corner(c);
        return t;
      }
      t = welded_neighbour(t, clockwise ? previous_corner(c) : next_corner(c));
    } while (t != kNone && t != start);
    if (t == start) break;
  }
  return kNone;
}

void TriangleMesh::add_to(StateHash& hash) const {
  hash.add(data_.lattice.origin.x());
  hash.add(data_.lattice.origin.y());
  hash.add(data_.lattice.spacing);
  for (const double value : {data_.bounds.min().x(), data_.bounds.min().y(), data_.bounds.max().x(),
                             data_.bounds.max().y(), data_.lengths.mean}) {
    hash.add(value);
  }
  if (!data_.lengths.is_uniform()) hash.add_span(std::span<const std::int8_t>(data_.lengths.exponents));
  hash.add(num_points());
  for (const PointRecord& point : data_.points) {
    hash.add(point.at.x);
    hash.add(point.at.y);
    hash.add(point.triangle);
  }
  hash.add(num_vertices());
  hash.add_span(std::span<const VertexRecord>(data_.vertices));
  hash.add(num_triangle_slots());
  const auto pair = [](std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
  };
  for (const TriangleRecord& r : data_.triangles) {  // by field: the record has padding
    for (int k = 0; k < 3; ++k) {
      hash.add(pair(r.points[k], r.neighbours[k]));
      hash.add(pair(r.vertices[k], r.locks[k]));
    }
    hash.add(pair(r.region, r.piece));
  }
  hash.add(data_.num_solid_triangles);
  hash.add(data_.num_pieces);
  if (is_curved()) data_.surface->add_to(hash);
}

std::uint64_t TriangleMesh::state_hash() const {
  StateHash hash;
  add_to(hash);
  return hash.value();
}

bool TriangleMesh::has_surface_of(const TriangleMesh& other) const {
  const RestSurface* const ours = data_.surface.get();
  const RestSurface* const theirs = other.data_.surface.get();
  return ours == theirs || (ours != nullptr && theirs != nullptr && *ours == *theirs);
}

bool operator==(const TriangleMesh& a, const TriangleMesh& b) {
  const MeshData& x = a.data_;
  const MeshData& y = b.data_;
  return x.lattice == y.lattice && x.bounds.min() == y.bounds.min() && x.bounds.max() == y.bounds.max() &&
         x.lengths == y.lengths && x.points == y.points && x.vertices == y.vertices && x.triangles == y.triangles &&
         x.num_solid_triangles == y.num_solid_triangles && x.num_pieces == y.num_pieces && a.has_surface_of(b);
}

}  // namespace kerf::mesh
