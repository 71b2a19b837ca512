#include "tests/audit/source_audit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "server/core/mesh/mesh_edit.h"

namespace kerf::audit {
namespace {

using Box = Eigen::AlignedBox2d;
using Eigen::Vector2d;
using mesh::kNone;
using mesh::LatticePoint;
using mesh::MeshData;
using mesh::TriangleRecord;
using mesh::VertexId;
using mesh::VertexSource;
using EdgeKind = OldMeshIndex::EdgeKind;

// Lattice units: a point within this distance of an older lip was laid on it.
constexpr double kOnLip = 12.0;

std::string text(const char* what, VertexId v) {
  return std::string(what) + ": vertex " + std::to_string(v);
}

class SourceAudit {
 public:
  SourceAudit(const MeshData& old, const MeshData& now, const mesh::MeshEdit& edit, OldMeshIndex& old_index)
      : old_(old), now_(now), edit_(edit), old_index_(old_index), first_slot_of_(now.vertices.size()) {
    for (std::size_t t = now.triangles.size(); t-- > 0;) {
      if (!is_solid(now.triangles[t])) continue;
      for (const VertexId v : now.triangles[t].vertices) first_slot_of_[index(v)] = t;
    }
  }

  Finding run() {
    if (Finding found = check_sources()) return found;
    return check_lip_sources();
  }

 private:
  // Checks one source: old vertices that share a triangle, weights that sum to 1, and the rest position that they give.
  Finding check_source(const VertexSource& source) {
    std::array<VertexId, 3> used{};
    std::size_t num_used = 0;
    Vector2d sum(0.0, 0.0);
    double weight = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId v = source.sources[k];
      const double w = source.weights[static_cast<Eigen::Index>(k)];
      if (v < 0 || index(v) >= old_.vertices.size()) return text("a source that is no old vertex", source.vertex);
      if (!(w >= 0.0)) return text("a weight below 0", source.vertex);
      weight += w;
      sum += w * as_vector(old_.points[index(old_.vertices[index(v)].point)].at);
      if (w > 0.0 && std::find(used.begin(), used.begin() + num_used, v) == used.begin() + num_used) {
        used[num_used++] = v;
      }
    }
    if (!(std::abs(weight - 1.0) <= 1e-14)) return text("weights that do not sum to 1", source.vertex);
    const LatticePoint& is = now_.points[index(now_.vertices[index(source.vertex)].point)].at;
    if ((sum - as_vector(is)).norm() > 1e-12 * 0x1.0p51) {
      return text("sources that give another rest position", source.vertex);
    }
    if (num_used == 3) {
      std::sort(used.begin(), used.end());
      if (!old_index_.has_triangle(used)) return text("sources that share no triangle", source.vertex);
    }
    if (num_used == 2 && old_index_.edge_kind(used[0], used[1]) == EdgeKind::kAbsent &&
        old_index_.edge_kind(used[1], used[0]) == EdgeKind::kAbsent) {
      return text("two sources that share no edge", source.vertex);
    }
    return std::nullopt;
  }

  Finding check_sources() {
    const auto& added = edit_.added_vertices;
    if (added.size() != now_.vertices.size() - old_.vertices.size()) return "added_vertices has another length";
    for (std::size_t i = 0; i < added.size(); ++i) {
      if (index(added[i].vertex) != old_.vertices.size() + i) return "added_vertices out of order";
      if (Finding found = check_source(added[i])) return found;
    }
    for (const VertexSource& source : edit_.moved_vertices) {
      if (Finding found = check_source(source)) return found;
    }
    return std::nullopt;
  }

  // Checks that each vertex inherits from its own side of every old lip.
  Finding check_lip_sources() {
    std::map<mesh::PointId, const VertexSource*> first_at;
    for (std::size_t v = 0; v < now_.vertices.size(); ++v) {
      if (now_.vertices[v].triangle == kNone) continue;
      const mesh::PointId p = now_.vertices[v].point;
      const bool is_new = v >= old_.vertices.size();
      const VertexSource* source = is_new ? &edit_.added_vertices[v - old_.vertices.size()] : nullptr;
      if (index(p) < old_.points.size()) {
        if (old_.points[index(p)].at != now_.points[index(p)].at) continue;  // moved: interpolated
        if (Finding found = check_sector(v, p, source)) return found;
      } else if (lies_on_lip(*source)) {
        if (Finding found = check_side(v, *source)) return found;
      } else {
        const auto [other, is_first] = first_at.try_emplace(p, source);
        if (!is_first && (other->second->sources != source->sources || other->second->weights != source->weights)) {
          return text("lips that differ at birth", static_cast<VertexId>(v));
        }
      }
    }
    return std::nullopt;
  }

  // Checks a vertex at an old point: it must be a copy of the old vertex in whose sector it lies.
  Finding check_sector(std::size_t v, mesh::PointId p, const VertexSource* source) {
    VertexId origin = static_cast<VertexId>(v);
    if (source != nullptr) {
      origin = source->sources[0];
      for (int k = 0; k < 3; ++k) {
        if (source->weights[k] != (k == 0 ? 1.0 : 0.0) && source->sources[static_cast<std::size_t>(k)] != origin) {
          return text("a copy made of several vertices", source->vertex);
        }
      }
      if (old_.vertices[index(origin)].point != p) return text("a copy of a vertex elsewhere", source->vertex);
    }
    if (first_slot_of_[v] < first_slot_of_[index(origin)] || now_.vertices[index(origin)].triangle == kNone) {
      return text("the vertex was not kept by the sector with the lowest slot", origin);
    }
    const LatticePoint& here = now_.points[index(p)].at;
    const LatticePoint tripled = tripled_centre(now_, now_.triangles[first_slot_of_[v]]);
    const LatticePoint direction{tripled.x - 3 * here.x, tripled.y - 3 * here.y};
    for (const std::size_t t : old_index_.solid_slots_at(p)) {
      const TriangleRecord& r = old_.triangles[t];
      const auto k = static_cast<std::size_t>(std::find(r.points.begin(), r.points.end(), p) - r.points.begin());
      const LatticePoint right = minus(old_.points[index(r.points[(k + 1) % 3])].at, here);
      const LatticePoint left = minus(old_.points[index(r.points[(k + 2) % 3])].at, here);
      if (turn(right, direction) < 0 || turn(direction, left) < 0) continue;
      if (r.vertices[k] == origin) return std::nullopt;
    }
    return text("in a sector that belonged to another vertex", static_cast<VertexId>(v));
  }

  // Returns true if the vertex's point was laid on an existing lip or border.
  bool lies_on_lip(const VertexSource& source) {
    const LatticePoint& place = now_.points[index(now_.vertices[index(source.vertex)].point)].at;
    const Vector2d here = as_vector(place);
    bool found = false;
    old_index_.for_touching(Box(here.array() - kOnLip, here.array() + kOnLip),
                            [&](const TriangleRecord& r, std::size_t) {
                              for (std::size_t k = 0; k < 3; ++k) {
                                if (r.locks[k] == 0) continue;
                                const Vector2d a = as_vector(old_.points[index(r.points[(k + 1) % 3])].at);
                                const Vector2d along = as_vector(old_.points[index(r.points[(k + 2) % 3])].at) - a;
                                const double t = std::clamp((here - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
                                found = found || (here - a - t * along).norm() < kOnLip;
                              }
                            });
    return found;
  }

  Finding check_side(std::size_t v, const VertexSource& source) {
    std::array<VertexId, 2> ends{kNone, kNone};
    std::size_t num_ends = 0;
    for (int k = 0; k < 3; ++k) {
      if (source.weights[k] == 0.0) continue;
      if (num_ends == 2) return text("on a lip, but made of three vertices", source.vertex);
      ends[num_ends++] = source.sources[static_cast<std::size_t>(k)];
    }
    if (num_ends == 1) return std::nullopt;
    auto [a, b] = ends;
    if (old_index_.edge_kind(a, b) != EdgeKind::kOpen) std::swap(a, b);
    if (old_index_.edge_kind(a, b) != EdgeKind::kOpen) return text("on a lip, but not made of its ends", source.vertex);
    const auto is_left = [&](VertexId from, VertexId to) {
      const LatticePoint& start = old_.points[index(old_.vertices[index(from)].point)].at;
      const LatticePoint& end = old_.points[index(old_.vertices[index(to)].point)].at;
      const LatticePoint tripled = tripled_centre(now_, now_.triangles[first_slot_of_[v]]);
      return turn(minus(end, start), {tripled.x - 3 * start.x, tripled.y - 3 * start.y}) > 0;
    };
    // Both sides of a lip have the same two vertices only if both are tips.
    if (is_left(a, b) || (old_index_.edge_kind(b, a) == EdgeKind::kOpen && is_left(b, a))) return std::nullopt;
    return text("made of the other side's vertices", source.vertex);
  }

  const MeshData& old_;
  const MeshData& now_;
  const mesh::MeshEdit& edit_;
  OldMeshIndex& old_index_;
  std::vector<std::size_t> first_slot_of_;  // lowest slot of each vertex of the mesh after the cut
};

}  // namespace

Finding find_source_flaw(const MeshData& old, const MeshData& now, const mesh::MeshEdit& edit,
                         OldMeshIndex& old_index) {
  return SourceAudit(old, now, edit, old_index).run();
}

}  // namespace kerf::audit
