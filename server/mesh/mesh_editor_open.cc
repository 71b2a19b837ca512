// Opening: the corner -> vertex map and the pieces, brought up to date along fresh cuts.

#include <algorithm>

#include "server/base/check.h"
#include "server/mesh/mesh_editor.h"
#include "server/mesh/piece_split.h"

namespace kerf::mesh {

// The edge before the edit that holds edge k of t, if that was locked then.
MeshEditor::Lip MeshEditor::lip_of_edge(TriangleId t, int k) const {
  const LockBits bits = mesh_.locks(t, k);
  if ((bits & kLocksThatOpen) == 0 || (bits & kLockFresh) != 0) return {};
  for (const PointId end : {mesh_.points(t)[next_corner(k)], mesh_.points(t)[previous_corner(k)]}) {
    if (is_new(end)) return lips_[end - log_.num_points];  // an old lock ends at a new point only where it was split
  }
  return old_edge(t, k);
}

// Finds edge k of t, between two points that are not new and locked before the edit, in the mesh before the edit.
MeshEditor::Lip MeshEditor::old_edge(TriangleId t, int k) const {
  const PointId a = mesh_.points(t)[next_corner(k)];
  const PointId b = mesh_.points(t)[previous_corner(k)];
  const auto corner_in = [](const TriangleRecord& record, PointId p) {
    return static_cast<int>(std::find(record.points.begin(), record.points.end(), p) - record.points.begin());
  };
  const auto entry = point_entry_.find(a);
  const TriangleId start =
      entry == point_entry_.end() ? mesh_.records().points[a].triangle : log_.points[entry->second].second.triangle;
  TriangleId s = start;
  do {
    const TriangleRecord& record = old_record(s);
    const int c = corner_in(record, a);
    if (record.points[next_corner(c)] == b) return {s, previous_corner(c)};
    s = record.neighbours[next_corner(c)];
  } while (s != start && s != kNone);
  KERF_CHECK(false, "a lock that is not fresh was an edge before the edit");
  return {};
}

std::vector<MeshEditor::Sector> MeshEditor::sectors_around(PointId p) const {
  std::vector<TriangleId> fan;
  mesh_.fan_around(p, fan);
  // separates[i]: between fan[i] and the next one counter-clockwise.
  const std::size_t n = fan.size();
  std::vector<bool> separates(n);
  std::size_t first = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const int k = next_corner(mesh_.corner_of(fan[i], p));
    separates[i] = (mesh_.locks(fan[i], k) & kLocksThatOpen) != 0;
    if (separates[i]) first = (i + 1) % n;
  }
  std::size_t lip_first = 0, lip_last = 0;
  const Lip lip = lip_left_of(p, fan, lip_first, lip_last);
  std::vector<Sector> sectors;
  for (std::size_t offset = 0; offset < n; ++offset) {
    const std::size_t i = (first + offset) % n;
    if (!mesh_.is_solid(fan[i])) continue;
    if (sectors.empty() || separates[(i + n - 1) % n]) {
      Sector sector;
      if (lip.triangle != kNone) {
        const bool is_left = (i + n - lip_first) % n <= (lip_last + n - lip_first) % n;
        const TriangleRecord& record = old_record(lip.triangle);
        if (is_left) {
          sector.lip = lip;
        } else {
          const TriangleId mirror = record.neighbours[lip.corner];
          const std::array<PointId, 3>& across = old_record(mirror).points;
          const PointId end = record.points[previous_corner(lip.corner)];
          const auto at_end = std::find(across.begin(), across.end(), end);
          sector.lip = {mirror, previous_corner(static_cast<int>(at_end - across.begin()))};
        }
      }
      sector.lowest = fan[i];
      sectors.push_back(std::move(sector));
    }
    sectors.back().triangles.push_back(fan[i]);
    sectors.back().lowest = std::min(sectors.back().lowest, fan[i]);
  }
  std::sort(sectors.begin(), sectors.end(), [](const Sector& a, const Sector& b) { return a.lowest < b.lowest; });
  return sectors;
}

// For a new point on an edge that was locked before the edit: that edge, and which run of the fan, first..last
// cyclically, lies to the left of it. Told by the edge's two remaining halves at the point, not by position: the point
// was rounded.
MeshEditor::Lip MeshEditor::lip_left_of(PointId p, const std::vector<TriangleId>& fan, std::size_t& first,
                                        std::size_t& last) const {
  if (!is_new(p)) return {};
  const Lip lip = lips_[p - log_.num_points];
  if (lip.triangle == kNone) return {};
  const TriangleRecord& record = old_record(lip.triangle);
  const LatticePoint& a = old_at(record.points[next_corner(lip.corner)]);
  const LatticePoint& b = old_at(record.points[previous_corner(lip.corner)]);
  int num_halves = 0;
  for (std::size_t i = 0; i < fan.size(); ++i) {
    const int c = mesh_.corner_of(fan[i], p);
    const LockBits bits = mesh_.locks(fan[i], next_corner(c));
    if ((bits & kLocksThatOpen) == 0 || (bits & kLockFresh) != 0) continue;
    ++num_halves;
    const LatticePoint& end = mesh_.at(mesh_.points(fan[i])[previous_corner(c)]);
    if (dot(a, b, mesh_.at(p), end) > 0) {
      first = (i + 1) % fan.size();  // counter-clockwise from the half towards b ...
    } else {
      last = i;  // ... to the half towards a
    }
  }
  KERF_CHECK(num_halves == 2, "a split lock leaves two halves");
  return lip;
}

void MeshEditor::add_vertex(PointId p, const Sector& sector, VertexId held) {
  Birth birth;
  birth.vertex = mesh_.num_vertices();
  if (held == kNone) {
    birth.lip = sector.lip;
  } else if (held < log_.num_vertices) {
    birth.origin = held;
  } else {
    birth.origin = births_[held - log_.num_vertices].origin;
    birth.lip = births_[held - log_.num_vertices].lip;
  }
  births_.push_back(birth);
  mesh_.records_.vertices.push_back({p, sector.lowest});
}

void MeshEditor::open_point(PointId p) {
  std::vector<VertexId> kept;
  for (const Sector& sector : sectors_around(p)) {
    const TriangleId lowest = sector.lowest;
    VertexId v = mesh_.record(lowest).vertices[mesh_.corner_of(lowest, p)];
    if (v == kNone || std::find(kept.begin(), kept.end(), v) != kept.end()) {
      const VertexId held = v;
      v = mesh_.num_vertices();
      add_vertex(p, sector, held);
    } else {
      kept.push_back(v);
      if (mesh_.records_.vertices[v].triangle != lowest) touch_vertex(v).triangle = lowest;
    }
    for (const TriangleId t : sector.triangles) {
      const int c = mesh_.corner_of(t, p);
      if (mesh_.record(t).vertices[c] != v) touch_triangle(t).vertices[c] = v;
    }
  }
}

void MeshEditor::label_pieces() {
  std::vector<TriangleId> seeds;
  std::vector<TriangleId> fan;
  for (const PointId p : pending_) {
    mesh_.fan_around(p, fan);
    for (const TriangleId t : fan) {
      const LockBits bits = static_cast<LockBits>(mesh_.locks(t, 0) | mesh_.locks(t, 1) | mesh_.locks(t, 2));
      if ((bits & kLockFresh) != 0) seeds.push_back(t);
    }
  }
  for (const std::vector<TriangleId>& component : split_off_components(mesh_, seeds)) {
    const std::int32_t parent = mesh_.piece(component.front());
    split_from_.push_back(parent < log_.num_pieces ? parent
                                                   : split_from_[static_cast<std::size_t>(parent - log_.num_pieces)]);
    const std::int32_t piece = mesh_.records_.num_pieces++;
    for (const TriangleId t : component) touch_triangle(t).piece = piece;
  }
}

void MeshEditor::open() {
  std::sort(pending_.begin(), pending_.end());
  pending_.erase(std::unique(pending_.begin(), pending_.end()), pending_.end());
  for (const PointId p : pending_) open_point(p);
  label_pieces();
  pending_.clear();
}

}  // namespace kerf::mesh
