#include "tests/audit/mesh_audit.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "tests/audit/exact_geometry.h"
#include "tests/audit/union_find.h"

namespace kerf::audit {
namespace {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::TriangleRecord;

constexpr std::int64_t kRim = std::int64_t{1} << 52;  // half the side of the domain, lattice units

std::string at_slot(const char* what, std::int32_t slot) {
  return std::string(what) + " (slot " + std::to_string(slot) + ")";
}

// Represents the side of a slot opposite corner k, which is one side of a welded edge (an edge between points).
struct Side {
  std::int32_t low = 0, high = 0;  // points
  std::int32_t slot = 0;
  int k = 0;
  bool ascends = false;  // true if it runs from low to high, counter-clockwise around the slot
  // Orders sides by their points, then by direction, as one number: sorting takes most of the time of an audit.
  [[nodiscard]] std::uint64_t key() const {
    return (static_cast<std::uint64_t>(low) << 33) | (static_cast<std::uint64_t>(high) << 1) | (ascends ? 1 : 0);
  }
  friend bool operator<(const Side& a, const Side& b) { return a.key() < b.key(); }
};

class Audit {
 public:
  explicit Audit(const mesh::TriangleMesh& mesh)
      : data_(mesh.data()), triangles_(data_.triangles), corners_(3 * triangles_.size()), pieces_(triangles_.size()) {}

  Finding run(Census* census) {
    for (const auto check : {&Audit::check_ranges, &Audit::check_areas, &Audit::check_edges, &Audit::check_vertices,
                             &Audit::check_pieces, &Audit::check_boundary}) {
      if (Finding found = (this->*check)()) return found;
    }
    if (census != nullptr) *census = census_;
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::int32_t num_slots() const { return static_cast<std::int32_t>(triangles_.size()); }

  Finding check_ranges() {
    const auto in = [](std::int32_t id, std::size_t size) { return id >= 0 && index(id) < size; };
    for (std::int32_t t = 0; t < num_slots(); ++t) {
      const TriangleRecord& r = triangles_[index(t)];
      if (r.region < kNone) return at_slot("a negative region", t);
      for (std::size_t k = 0; k < 3; ++k) {
        if (!in(r.points[k], data_.points.size())) return at_slot("a corner at no point", t);
        if (is_solid(r) != in(r.vertices[k], data_.vertices.size())) {
          return at_slot("a solid corner without vertex, or a void one with one", t);
        }
        if (is_solid(r) && data_.vertices[index(r.vertices[k])].point != r.points[k]) {
          return at_slot("a vertex that lies elsewhere", t);
        }
        if (r.neighbours[k] != kNone && !in(r.neighbours[k], triangles_.size())) return at_slot("no such neighbour", t);
      }
      if (is_solid(r)) ++census_.triangles;
    }
    if (census_.triangles != data_.num_solid_triangles) return "the number of solid triangles is wrong";
    return std::nullopt;
  }

  Finding check_areas() {
    Wide total = 0;
    for (std::int32_t t = 0; t < num_slots(); ++t) {
      const TriangleRecord& r = triangles_[index(t)];
      const LatticePoint& a = data_.points[index(r.points[0])].at;
      const LatticePoint& b = data_.points[index(r.points[1])].at;
      const LatticePoint& c = data_.points[index(r.points[2])].at;
      const Wide doubled = Wide{a.x - c.x} * (b.y - c.y) - Wide{a.y - c.y} * (b.x - c.x);
      if (doubled <= 0) return at_slot("a rest triangle that is not counter-clockwise", t);
      total += doubled;
    }
    if (total != Wide{8} * kRim * kRim) return "the slots do not tile the domain";
    return std::nullopt;
  }

  // Checks that every welded edge has two sides that are neighbours. Joins corners and slots that are connected across
  // it.
  Finding check_edges() {
    sides_.reserve(3 * triangles_.size());
    for (std::int32_t t = 0; t < num_slots(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const std::int32_t from = triangles_[index(t)].points[index((k + 1) % 3)];
        const std::int32_t to = triangles_[index(t)].points[index((k + 2) % 3)];
        sides_.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
      }
    }
    std::sort(sides_.begin(), sides_.end());
    degree_.assign(data_.points.size(), 0);
    for (std::size_t i = 0; i < sides_.size();) {
      const Side& first = sides_[i];
      std::size_t end = i + 1;
      while (end < sides_.size() && sides_[end].low == first.low && sides_[end].high == first.high) ++end;
      if (end - i == 1) {
        if (Finding found = check_rim(first)) return found;
      } else if (end - i == 2) {
        if (Finding found = check_pair(first, sides_[i + 1])) return found;
      } else {
        return at_slot("more than two triangles at one edge", first.slot);
      }
      i = end;
    }
    return std::nullopt;
  }

  [[nodiscard]] Finding check_rim(const Side& side) const {
    const TriangleRecord& r = triangles_[index(side.slot)];
    const LatticePoint& a = data_.points[index(side.low)].at;
    const LatticePoint& b = data_.points[index(side.high)].at;
    const bool on_rim = (a.x == b.x && std::abs(a.x) == kRim) || (a.y == b.y && std::abs(a.y) == kRim);
    if (!on_rim) return at_slot("an edge with one side only", side.slot);
    if (is_solid(r) || r.locks[index(side.k)] != 0 || r.neighbours[index(side.k)] != kNone) {
      return at_slot("something at the rim of the domain", side.slot);
    }
    return std::nullopt;
  }

  Finding check_pair(const Side& a, const Side& b) {
    const TriangleRecord& s = triangles_[index(a.slot)];
    const TriangleRecord& t = triangles_[index(b.slot)];
    if (a.ascends == b.ascends) return at_slot("two triangles on the same side of an edge", a.slot);
    if (s.neighbours[index(a.k)] != b.slot || t.neighbours[index(b.k)] != a.slot) {
      return at_slot("neighbours that do not know each other", a.slot);
    }
    const mesh::LockBits locks = s.locks[index(a.k)];
    if (locks != t.locks[index(b.k)]) return at_slot("locks that differ on the two sides", a.slot);
    if ((locks & ~(mesh::kLockBorder | mesh::kLockCut)) != 0) return at_slot("a lock left over from the edit", a.slot);
    if (((locks & mesh::kLockBorder) != 0) != (is_solid(s) != is_solid(t))) {
      return at_slot("a border lock in the wrong place", a.slot);
    }
    if ((locks & mesh::kLockCut) != 0 && !(is_solid(s) && is_solid(t))) return at_slot("a cut in the void", a.slot);
    if (locks != 0) {
      ++degree_[index(a.low)];
      ++degree_[index(a.high)];
    }
    if (!is_solid(s) && !is_solid(t)) return std::nullopt;
    if (locks == 0) {
      join_corners(a, b);
      pieces_.join(index(a.slot), index(b.slot));
      ++census_.edges;
    } else if ((locks & mesh::kLockCut) != 0) {
      ++census_.lip_edges;
      census_.edges += 2;
      cuts_.push_back({a, b});
    } else {
      ++census_.edges;
    }
    return std::nullopt;
  }

  // Returns the corner of a side at the lower or higher of its points.
  static std::size_t corner_at(const Side& side, bool low) {
    return 3 * index(side.slot) + index((side.k + (low == side.ascends ? 1 : 2)) % 3);
  }
  void join_corners(const Side& a, const Side& b) {
    for (const bool low : {true, false}) corners_.join(corner_at(a, low), corner_at(b, low));
  }
  [[nodiscard]] std::int32_t vertex_of(std::size_t corner) const { return triangles_[corner / 3].vertices[corner % 3]; }

  // Checks that each sector has one vertex, and each vertex one sector.
  Finding check_vertices() {
    std::vector<std::size_t> sector(data_.vertices.size(), 3 * triangles_.size());
    std::vector<std::int32_t> num_vertices(data_.points.size(), 0);
    for (std::int32_t t = 0; t < num_slots(); ++t) {
      if (!is_solid(triangles_[index(t)])) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t corner = 3 * index(t) + k;
        std::size_t& known = sector[index(vertex_of(corner))];
        if (known == 3 * triangles_.size()) {
          known = corners_.root(corner);
          ++num_vertices[index(triangles_[index(t)].points[k])];
        }
        if (known != corners_.root(corner)) return at_slot("one vertex for two sectors: a bow-tie", t);
        if (vertex_of(known) != vertex_of(corner)) return at_slot("two vertices in one sector", t);
      }
    }
    for (std::size_t v = 0; v < sector.size(); ++v) {
      if (sector[v] == 3 * triangles_.size()) {
        if (data_.vertices[v].triangle != kNone) return "vertex " + std::to_string(v) + " is used by no triangle";
        continue;
      }
      ++census_.vertices;
      if (data_.vertices[v].triangle == kNone) return "vertex " + std::to_string(v) + " names no triangle";
      const auto& named = triangles_[index(data_.vertices[v].triangle)].vertices;
      if (std::find(named.begin(), named.end(), static_cast<std::int32_t>(v)) == named.end()) {
        return "vertex " + std::to_string(v) + " names a triangle without it";
      }
    }
    for (std::size_t p = 0; p < data_.points.size(); ++p) {
      const auto& named = triangles_[index(data_.points[p].triangle)].points;
      if (std::find(named.begin(), named.end(), static_cast<std::int32_t>(p)) == named.end()) {
        return "point " + std::to_string(p) + " names a triangle without it";
      }
      if (degree_[p] > 0) ++census_.points_by_degree[index(std::min(degree_[p], 5))];
      if (num_vertices[p] == 0) continue;
      ++census_.welded_vertices;
      census_.extra_fans += num_vertices[p] - 1;
      if (degree_[p] == 1 && num_vertices[p] != 1) return "the tip at point " + std::to_string(p) + " is not single";
    }
    for (const auto& [a, b] : cuts_) {
      if (vertex_of(corner_at(a, true)) == vertex_of(corner_at(b, true)) &&
          vertex_of(corner_at(a, false)) == vertex_of(corner_at(b, false))) {
        return at_slot("a lip that is not open", a.slot);
      }
    }
    return std::nullopt;
  }

  Finding check_pieces() {
    std::vector<std::size_t> component(index(data_.num_pieces), triangles_.size());
    for (std::int32_t t = 0; t < num_slots(); ++t) {
      const TriangleRecord& r = triangles_[index(t)];
      if (!is_solid(r)) {
        if (r.piece != kNone) return at_slot("void with a piece", t);
        continue;
      }
      if (r.piece < 0 || r.piece >= data_.num_pieces) return at_slot("a piece that does not exist", t);
      std::size_t& known = component[index(r.piece)];
      if (known == triangles_.size()) known = pieces_.root(index(t));
      if (known != pieces_.root(index(t))) return at_slot("one number for two pieces", t);
      if (pieces_.root(index(t)) == index(t)) ++census_.pieces;
    }
    if (census_.pieces != data_.num_pieces) return "the number of pieces is wrong";
    return std::nullopt;
  }

  // Checks that boundary edges form closed chains that meet no vertex twice, then Euler's formula for pieces of genus
  // 0.
  Finding check_boundary() {
    std::vector<std::int32_t> next(data_.vertices.size(), kNone);
    const auto add = [&](const Side& side) -> Finding {
      const TriangleRecord& r = triangles_[index(side.slot)];
      std::int32_t& follower = next[index(r.vertices[index((side.k + 1) % 3)])];
      if (follower != kNone) return at_slot("a vertex on two boundaries", side.slot);
      follower = r.vertices[index((side.k + 2) % 3)];
      return std::nullopt;
    };
    for (const Side& side : sides_) {
      const TriangleRecord& r = triangles_[index(side.slot)];
      if (!is_solid(r) || r.locks[index(side.k)] == 0) continue;
      if (Finding found = add(side)) return found;
    }
    for (std::size_t start = 0; start < next.size(); ++start) {
      if (next[start] == kNone) continue;
      ++census_.loops;
      for (std::size_t at = start; next[at] != kNone;) {
        const std::size_t follower = index(next[at]);
        next[at] = kNone;
        at = follower;
        if (next[at] == kNone && at != start) return "a boundary that is not closed";
      }
    }
    if (census_.characteristic() != 2 * census_.pieces - census_.loops) return "Euler's formula does not hold";
    return std::nullopt;
  }

  const mesh::MeshData& data_;
  const std::vector<TriangleRecord>& triangles_;
  UnionFind corners_;  // sectors: sets of corners 3 t + k
  UnionFind pieces_;   // sets of slots
  std::vector<Side> sides_;
  std::vector<std::array<Side, 2>> cuts_;
  std::vector<int> degree_;  // by point: open edges that meet there
  Census census_;
};

}  // namespace

Finding find_flaw(const mesh::TriangleMesh& mesh, Census* census) {
  return Audit(mesh).run(census);
}

}  // namespace kerf::audit
