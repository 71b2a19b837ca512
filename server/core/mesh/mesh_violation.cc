// Implements TriangleMesh::find_violation. The checks run in order; each may assume only what the earlier ones have
// shown.

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {
namespace {

using Violation = std::optional<std::string>;

std::string at_slot(const char* what, TriangleId t) {
  return std::string(what) + " at slot " + std::to_string(t);
}
std::string at_edge(const char* what, TriangleId t, int k) {
  return at_slot(what, t) + ", edge " + std::to_string(k);
}

class MeshChecker {
 public:
  explicit MeshChecker(const TriangleMesh& mesh) : mesh_(mesh), data_(mesh.data()) {}

  Violation run() {
    for (const auto check :
         {&MeshChecker::indices, &MeshChecker::adjacency, &MeshChecker::orientation, &MeshChecker::locks,
          &MeshChecker::borders, &MeshChecker::corners, &MeshChecker::welding, &MeshChecker::anchors,
          &MeshChecker::sectors, &MeshChecker::tiling, &MeshChecker::pieces, &MeshChecker::euler}) {
      if (Violation found = (this->*check)()) return found;
    }
    return std::nullopt;
  }

 private:
  static bool in_range(std::int32_t id, std::int32_t size) { return id >= 0 && id < size; }

  Violation indices() {
    if (Violation found = triangle_indices()) return found;
    for (const PointRecord& p : data_.points) {
      if (!in_range(p.triangle, mesh_.num_triangle_slots())) return "I1: triangle id of a point out of range";
      if (std::abs(p.at.x) > kMaxCoordinate || std::abs(p.at.y) > kMaxCoordinate) return "I1: point outside the domain";
    }
    for (const VertexRecord& v : data_.vertices) {
      if (v.triangle != kNone && !in_range(v.triangle, mesh_.num_triangle_slots())) {
        return "I1: triangle id of a vertex out of range";
      }
      if (!in_range(v.point, mesh_.num_points())) return "I1: point id of a vertex out of range";
    }
    return std::nullopt;
  }

  Violation triangle_indices() {
    std::int32_t num_solid = 0;
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      const TriangleRecord& r = mesh_.record(t);
      for (int k = 0; k < 3; ++k) {
        if (!in_range(r.points[k], mesh_.num_points())) return at_slot("I1: point id out of range", t);
        if (r.points[k] == r.points[next_corner(k)]) return at_slot("I1: two corners at one point", t);
        if (r.neighbours[k] != kNone && !in_range(r.neighbours[k], mesh_.num_triangle_slots())) {
          return at_slot("I1: neighbour id out of range", t);
        }
        if (r.vertices[k] != kNone && !in_range(r.vertices[k], mesh_.num_vertices())) {
          return at_slot("I1: vertex id out of range", t);
        }
      }
      if (r.region < kNone) return at_slot("I1: negative region", t);
      if (r.region != kNone) ++num_solid;
    }
    if (num_solid != mesh_.num_solid_triangles()) return "I1: num_solid_triangles is wrong";
    return std::nullopt;
  }

  Violation adjacency() {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      const TriangleRecord& r = mesh_.record(t);
      for (int k = 0; k < 3; ++k) {
        const TriangleId n = r.neighbours[k];
        if (n == kNone) continue;
        const int c = mesh_.corner_of(n, r.points[previous_corner(k)]);
        if (c == kNone) return at_edge("I2: neighbour lacks an end of the edge", t, k);
        const int m = previous_corner(c);
        if (mesh_.record(n).points[previous_corner(m)] != r.points[next_corner(k)]) {
          return at_edge("I2: neighbour lacks an end of the edge", t, k);
        }
        if (mesh_.record(n).neighbours[m] != t) return at_edge("I2: adjacency is not symmetric", t, k);
      }
    }
    return std::nullopt;
  }

  Violation orientation() {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      const std::array<PointId, 3>& p = mesh_.points(t);
      if (orient2d(mesh_.at(p[0]), mesh_.at(p[1]), mesh_.at(p[2])) <= 0) return at_slot("I3: area not positive", t);
    }
    return std::nullopt;
  }

  Violation locks() {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const LockBits bits = mesh_.locks(t, k);
        if ((bits & ~kLocksThatOpen) != 0) return at_edge("I4: lock of one edit left", t, k);
        const TriangleId n = mesh_.welded_neighbour(t, k);
        if (n != kNone && mesh_.locks(n, mesh_.mirror_corner(t, k)) != bits) {
          return at_edge("I4: locks differ on the two sides", t, k);
        }
      }
    }
    return std::nullopt;
  }

  Violation borders() {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const TriangleId n = mesh_.welded_neighbour(t, k);
        const bool is_border = (mesh_.locks(t, k) & kLockBorder) != 0;
        if (n == kNone) {
          if (Violation found = rim(t, k)) return found;
          continue;
        }
        if (is_border != (mesh_.is_solid(t) != mesh_.is_solid(n))) {
          return at_edge("I5: border lock where solid does not meet void, or none where it does", t, k);
        }
        if ((mesh_.locks(t, k) & kLockCut) != 0 && !(mesh_.is_solid(t) && mesh_.is_solid(n))) {
          return at_edge("I5: cut in the void", t, k);
        }
      }
    }
    return std::nullopt;
  }

  Violation rim(TriangleId t, int k) {
    if (mesh_.is_solid(t)) return at_edge("I5: solid at the rim of the domain", t, k);
    if (mesh_.locks(t, k) != 0) return at_edge("I5: lock on the rim of the domain", t, k);
    const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
    const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
    const bool on_rim =
        (a.x == b.x && std::abs(a.x) == Lattice::kHalfDomain) || (a.y == b.y && std::abs(a.y) == Lattice::kHalfDomain);
    if (!on_rim) return at_edge("I5: no neighbour inside the domain", t, k);
    return std::nullopt;
  }

  Violation corners() {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const VertexId v = mesh_.vertices(t)[k];
        if (mesh_.is_solid(t) != (v != kNone))
          return at_slot("I6: solid corner without vertex or void corner with one", t);
        if (v != kNone && mesh_.point(v) != mesh_.points(t)[k]) return at_slot("I6: vertex at another point", t);
      }
    }
    return std::nullopt;
  }

  Violation welding() {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const TriangleId n = mesh_.neighbour(t, k);
        if (n == kNone) continue;
        const int m = mesh_.mirror_corner(t, k);
        if (mesh_.vertices(t)[next_corner(k)] != mesh_.vertices(n)[previous_corner(m)] ||
            mesh_.vertices(t)[previous_corner(k)] != mesh_.vertices(n)[next_corner(m)]) {
          return at_edge("I7: vertices differ across an edge that is not cut", t, k);
        }
      }
    }
    return std::nullopt;
  }

  Violation anchors() {
    for (PointId p = 0; p < mesh_.num_points(); ++p) {
      if (mesh_.corner_of(data_.points[p].triangle, p) == kNone) {
        return "I9: point " + std::to_string(p) + " names a triangle without it";
      }
    }
    for (VertexId v = 0; v < mesh_.num_vertices(); ++v) {
      if (!mesh_.has_material(v)) continue;
      const std::array<VertexId, 3>& corner = mesh_.vertices(mesh_.triangle_at(v));
      if (std::find(corner.begin(), corner.end(), v) == corner.end()) {
        return "I9: vertex " + std::to_string(v) + " names a triangle without it";
      }
    }
    return std::nullopt;
  }

  Violation sectors() {
    std::vector<std::int32_t> num_corners(static_cast<std::size_t>(mesh_.num_vertices()), 0);
    for (const TriangleRecord& r : data_.triangles) {
      for (const VertexId v : r.vertices) {
        if (v != kNone) ++num_corners[v];
      }
    }
    std::vector<TriangleId> ring;
    for (VertexId v = 0; v < mesh_.num_vertices(); ++v) {
      mesh_.triangles_around(v, ring);
      if (static_cast<std::int32_t>(ring.size()) != num_corners[v]) {
        return "I8: vertex " + std::to_string(v) + " has corners beside its one sector (bow-tie, or no sector named)";
      }
    }
    return std::nullopt;
  }

  Violation tiling() {
    std::vector<LatticePoint> points;
    points.reserve(data_.points.size());
    for (const PointRecord& p : data_.points) points.push_back(p.at);
    std::sort(points.begin(), points.end());
    if (std::adjacent_find(points.begin(), points.end()) != points.end()) return "I10: two points coincide";
    Int128 total = 0;
    for (const TriangleRecord& r : data_.triangles) {
      total += doubled_area(mesh_.at(r.points[0]), mesh_.at(r.points[1]), mesh_.at(r.points[2]));
    }
    const Int128 side = 2 * static_cast<Int128>(Lattice::kHalfDomain);
    if (total != 2 * side * side) return "I10: the area of all slots is not that of the domain";
    return std::nullopt;
  }

  Violation piece_numbers() {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      const std::int32_t piece = mesh_.piece(t);
      if (mesh_.is_solid(t) ? !in_range(piece, mesh_.num_pieces()) : piece != kNone) {
        return at_slot("I11: piece number out of range", t);
      }
    }
    return std::nullopt;
  }

  Violation pieces() {
    if (Violation found = piece_numbers()) return found;
    const std::int32_t n = mesh_.num_triangle_slots();
    std::vector<TriangleId> parent(static_cast<std::size_t>(n));
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](TriangleId t) {
      while (parent[t] != t) t = parent[t] = parent[parent[t]];
      return t;
    };
    std::int32_t num_components = mesh_.num_solid_triangles();
    for (TriangleId t = 0; t < n; ++t) {
      for (int k = 0; k < 3; ++k) {
        const TriangleId other = mesh_.neighbour(t, k);
        if (other == kNone) continue;
        if (mesh_.piece(other) != mesh_.piece(t))
          return at_edge("I11: piece numbers differ across an edge that is not cut", t, k);
        if (root(t) == root(other)) continue;
        parent[root(t)] = root(other);
        --num_components;
      }
    }
    if (num_components != mesh_.num_pieces()) return "I11: union-find counts another number of pieces";
    if (flooded_components() != mesh_.num_pieces()) return "I11: flood fill counts another number of pieces";
    std::vector<bool> seen(static_cast<std::size_t>(mesh_.num_pieces()));
    for (TriangleId t = 0; t < n; ++t) {
      if (!mesh_.is_solid(t) || root(t) != t) continue;
      if (seen[mesh_.piece(t)]) return at_slot("I11: one number for two pieces", t);
      seen[mesh_.piece(t)] = true;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::int32_t flooded_components() const {
    std::vector<bool> seen(static_cast<std::size_t>(mesh_.num_triangle_slots()));
    std::vector<TriangleId> stack;
    std::int32_t count = 0;
    for (TriangleId first = 0; first < mesh_.num_triangle_slots(); ++first) {
      if (!mesh_.is_solid(first) || seen[first]) continue;
      ++count;
      seen[first] = true;
      stack.push_back(first);
      while (!stack.empty()) {
        const TriangleId t = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
          const TriangleId n = mesh_.neighbour(t, k);
          if (n == kNone || seen[n]) continue;
          seen[n] = true;
          stack.push_back(n);
        }
      }
    }
    return count;
  }

  Violation euler() {
    std::int64_t num_open_sides = 0;
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      for (int k = 0; k < 3; ++k) {
        if (mesh_.is_solid(t) && mesh_.neighbour(t, k) == kNone) ++num_open_sides;
      }
    }
    const std::int64_t num_sides = 3 * static_cast<std::int64_t>(mesh_.num_solid_triangles());
    const std::int64_t num_edges = (num_sides + num_open_sides) / 2;
    std::int64_t num_vertices = 0;
    for (VertexId v = 0; v < mesh_.num_vertices(); ++v) num_vertices += mesh_.has_material(v) ? 1 : 0;
    const std::int64_t characteristic = num_vertices - num_edges + mesh_.num_solid_triangles();
    if (characteristic != 2 * static_cast<std::int64_t>(mesh_.num_pieces()) - mesh_.num_boundary_loops()) {
      return "I12: Euler's formula does not hold";
    }
    return std::nullopt;
  }

  const TriangleMesh& mesh_;
  const MeshData& data_;
};

}  // namespace

std::int32_t TriangleMesh::num_boundary_loops() const {
  std::vector<std::array<bool, 3>> seen(data_.triangles.size(), {false, false, false});
  std::int32_t count = 0;
  for (TriangleId first = 0; first < num_triangle_slots(); ++first) {
    for (int k = 0; k < 3; ++k) {
      if (!is_solid(first) || neighbour(first, k) != kNone || seen[first][k]) continue;
      ++count;
      TriangleId t = first;
      int side = k;
      while (!seen[t][side]) {
        seen[t][side] = true;
        side = next_corner(side);  // the edge that leaves the end of this one, turned clockwise until it is open too
        while (neighbour(t, side) != kNone) {
          const TriangleId n = neighbour(t, side);
          side = next_corner(mirror_corner(t, side));
          t = n;
        }
      }
    }
  }
  return count;
}

std::optional<std::string> TriangleMesh::find_violation() const {
  return MeshChecker(*this).run();
}

}  // namespace kerf::mesh
