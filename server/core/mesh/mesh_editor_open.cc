// Opening: updates the vertices of corners, and the pieces, along fresh cuts.

#include <algorithm>
#include <functional>
#include <optional>

#include "server/base/check.h"
#include "server/base/sort_unique.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/piece_split.h"

namespace kerf::mesh {

// Returns the edge, locked before the edit, that edge k of t is part of. Returns an empty Lip if there is none.
MeshEditor::Lip MeshEditor::lip_of_edge(TriangleId t, int k) const {
  const LockBits bits = mesh_.locks(t, k);
  if ((bits & kLocksThatOpen) == 0 || (bits & kLockFresh) != 0) return {};
  for (const PointId end : {mesh_.points(t)[next_corner(k)], mesh_.points(t)[previous_corner(k)]}) {
    if (is_new(end)) return lips_[end - log_.num_points];  // old locks end at new points only where they were split
  }
  return old_edge(t, k);
}

// Finds edge k of t in the mesh before the edit. It was locked then, and neither of its ends is new.
MeshEditor::Lip MeshEditor::old_edge(TriangleId t, int k) const {
  const PointId a = mesh_.points(t)[next_corner(k)];
  const PointId b = mesh_.points(t)[previous_corner(k)];
  const auto corner_in = [](const TriangleRecord& record, PointId p) {
    return static_cast<int>(std::find(record.points.begin(), record.points.end(), p) - record.points.begin());
  };
  const std::int32_t entry = point_entry_.find(a);
  const TriangleId start =
      entry == kNone ? mesh_.data().points[a].triangle : log_.points[static_cast<std::size_t>(entry)].second.triangle;
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

std::vector<MeshEditor::Sector> MeshEditor::sectors_around(PointId p, std::vector<TriangleId>& fan) const {
  mesh_.fan_around(p, fan);
  const auto ends_sector = [&](TriangleId t) {
    return (mesh_.locks(t, next_corner(mesh_.corner_of(t, p))) & kLocksThatOpen) != 0;
  };
  // Rotates the fan so that no sector continues from its end to its start.
  const auto last = std::find_if(fan.rbegin(), fan.rend(), ends_sector);
  if (last != fan.rend()) std::rotate(fan.begin(), last.base(), fan.end());
  const Lip lip = is_new(p) ? lips_[p - log_.num_points] : Lip{};
  const std::vector<bool> is_left = lip.triangle == kNone ? std::vector<bool>() : left_of_lip(p, lip, fan);
  std::vector<Sector> sectors;
  sectors.reserve(4);
  bool goes_on = false;
  for (std::size_t i = 0; i < fan.size(); ++i) {
    if (mesh_.is_solid(fan[i])) {
      if (!goes_on) {
        sectors.push_back({i, i, fan[i], {}});
        if (lip.triangle != kNone) sectors.back().lip = is_left[i] ? lip : across(lip);
      }
      sectors.back().end = i + 1;
      sectors.back().lowest = std::min(sectors.back().lowest, fan[i]);
    }
    goes_on = mesh_.is_solid(fan[i]) && !ends_sector(fan[i]);
  }
  std::sort(sectors.begin(), sectors.end(), [](const Sector& a, const Sector& b) { return a.lowest < b.lowest; });
  return sectors;
}

// Returns the locked edge as seen from the triangle on its other side.
MeshEditor::Lip MeshEditor::across(const Lip& lip) const {
  const TriangleRecord& record = old_record(lip.triangle);
  const TriangleId mirror = record.neighbours[lip.corner];
  const std::array<PointId, 3>& points = old_record(mirror).points;
  const auto at_end = std::find(points.begin(), points.end(), record.points[previous_corner(lip.corner)]);
  return {mirror, previous_corner(static_cast<int>(at_end - points.begin()))};
}

// Says for each triangle around p, a new point on an edge locked before the edit, whether it lies to the left of that
// edge. The two halves of the edge at p decide, not positions, as p was rounded. A half no longer exists if material
// was removed on both sides of it. If neither half exists, positions decide.
std::vector<bool> MeshEditor::left_of_lip(PointId p, const Lip& lip, const std::vector<TriangleId>& fan) const {
  const TriangleRecord& record = old_record(lip.triangle);
  const LatticePoint& a = old_at(record.points[next_corner(lip.corner)]);
  const LatticePoint& b = old_at(record.points[previous_corner(lip.corner)]);
  const std::size_t n = fan.size();
  std::optional<std::size_t> first, last;  // of the triangles on the left, in cyclic order
  for (std::size_t i = 0; i < n; ++i) {
    const int c = mesh_.corner_of(fan[i], p);
    const LockBits bits = mesh_.locks(fan[i], next_corner(c));
    if ((bits & kLocksThatOpen) == 0 || (bits & kLockFresh) != 0) continue;
    const LatticePoint& end = mesh_.at(mesh_.points(fan[i])[previous_corner(c)]);
    // Triangles on the left run counter-clockwise from the half towards b to the half towards a.
    std::optional<std::size_t>& bound = dot(a, b, mesh_.at(p), end) > 0 ? first : last;
    KERF_CHECK(!bound, "a split lock leaves one half on each side");
    bound = &bound == &first ? (i + 1) % n : i;
  }
  KERF_CHECK((first && last) || !orphaned_pieces_.empty(), "a split lock leaves two halves");
  std::vector<bool> is_left(n, false);
  if (!first && !last) {
    for (std::size_t i = 0; i < n; ++i) {
      Int128 side = 0;
      for (const PointId corner : mesh_.points(fan[i])) side += doubled_area(a, b, mesh_.at(corner));
      is_left[i] = side > 0;
    }
    return is_left;
  }
  // If only one half exists, the triangles on the left end at the void.
  for (std::size_t step = 0; step < n; ++step) {
    const std::size_t i = first ? (*first + step) % n : (*last + n - step) % n;
    if (!(first && last) && !mesh_.is_solid(fan[i])) break;
    is_left[i] = true;
    if (first && last && i == *last) break;
  }
  return is_left;
}

void MeshEditor::add_vertex(PointId p, const Sector& sector, VertexId held) {
  NewVertex added;
  added.vertex = mesh_.num_vertices();
  if (held == kNone) {
    added.lip = sector.lip;
  } else if (held < log_.num_vertices) {
    added.origin = held;
  } else {
    added.origin = new_vertices_[held - log_.num_vertices].origin;
    added.lip = new_vertices_[held - log_.num_vertices].lip;
  }
  new_vertices_.push_back(added);
  mesh_.data_.vertices.push_back({p, sector.lowest});
}

void MeshEditor::open_point(PointId p) {
  std::vector<TriangleId> fan;
  std::vector<VertexId> kept;
  for (const Sector& sector : sectors_around(p, fan)) {
    const TriangleId lowest = sector.lowest;
    VertexId v = mesh_.record(lowest).vertices[mesh_.corner_of(lowest, p)];
    if (v == kNone || std::find(kept.begin(), kept.end(), v) != kept.end()) {
      const VertexId held = v;
      v = mesh_.num_vertices();
      add_vertex(p, sector, held);
    } else {
      kept.push_back(v);
      if (mesh_.data_.vertices[v].triangle != lowest) touch_vertex(v).triangle = lowest;
    }
    for (std::size_t i = sector.begin; i < sector.end; ++i) {
      const int c = mesh_.corner_of(fan[i], p);
      if (mesh_.record(fan[i]).vertices[c] != v) touch_triangle(fan[i]).vertices[c] = v;
    }
  }
}

// Removes vertices of slots that were made void, if no solid slot has a corner there any more.
void MeshEditor::drop_orphaned_vertices() {
  sort_unique(orphaned_vertices_);
  for (const VertexId v : orphaned_vertices_) {
    const std::array<VertexId, 3>& corners = mesh_.vertices(mesh_.triangle_at(v));
    if (std::find(corners.begin(), corners.end(), v) != corners.end()) continue;
    touch_vertex(v).triangle = kNone;
    removed_vertices_.push_back(v);
  }
  orphaned_vertices_.clear();
}

void MeshEditor::label_pieces() {
  std::vector<TriangleId> seeds;
  std::vector<TriangleId> fan;
  for (const PointId p : pending_) {
    mesh_.fan_around(p, fan);
    for (const TriangleId t : fan) {
      const LockBits bits = static_cast<LockBits>(mesh_.locks(t, 0) | mesh_.locks(t, 1) | mesh_.locks(t, 2));
      if (mesh_.is_solid(t) && (bits & kLockFresh) != 0) seeds.push_back(t);
    }
  }
  label_split_pieces(seeds);
  drop_orphaned_pieces(seeds);
}

void MeshEditor::label_split_pieces(const std::vector<TriangleId>& seeds) {
  for (const std::vector<TriangleId>& component : split_off_components(mesh_, seeds)) {
    const std::int32_t parent = mesh_.piece(component.front());
    split_from_.push_back(parent < log_.num_pieces ? parent
                                                   : split_from_[static_cast<std::size_t>(parent - log_.num_pieces)]);
    const std::int32_t piece = mesh_.data_.num_pieces++;
    for (const TriangleId t : component) touch_triangle(t).piece = piece;
  }
}

// Removes pieces that lost all their material. A piece that kept some has a seed at the border of the removed part.
void MeshEditor::drop_orphaned_pieces(const std::vector<TriangleId>& seeds) {
  if (orphaned_pieces_.empty()) return;
  std::vector<bool> remains(static_cast<std::size_t>(mesh_.num_pieces()));
  for (const TriangleId t : seeds) {
    std::int32_t piece = mesh_.piece(t);
    if (piece >= log_.num_pieces) piece = split_from_[static_cast<std::size_t>(piece - log_.num_pieces)];
    remains[static_cast<std::size_t>(piece)] = true;
  }
  std::sort(orphaned_pieces_.begin(), orphaned_pieces_.end(), std::greater<>());
  orphaned_pieces_.erase(std::unique(orphaned_pieces_.begin(), orphaned_pieces_.end()), orphaned_pieces_.end());
  for (const std::int32_t gone : orphaned_pieces_) {
    if (remains[static_cast<std::size_t>(gone)]) continue;
    removed_pieces_.push_back(gone);
    const std::int32_t highest = --mesh_.data_.num_pieces;
    if (highest == gone) continue;
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) {
      if (mesh_.piece(t) == highest) touch_triangle(t).piece = gone;
    }
  }
  orphaned_pieces_.clear();
}

void MeshEditor::open() {
  sort_unique(pending_);
  for (const PointId p : pending_) open_point(p);
  drop_orphaned_vertices();
  label_pieces();
  pending_.clear();
}

}  // namespace kerf::mesh
