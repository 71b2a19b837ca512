// The elementary operations of MeshEditor: split, flip, lock, move. Corner names are those of the sketches in the
// header.

#include <cmath>
#include <cstdlib>

#include "server/base/check.h"
#include "server/core/mesh/mesh_editor.h"

namespace kerf::mesh {
namespace {

bool is_positive(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return orient2d(a, b, c) > 0;
}

}  // namespace

// Replaces the neighbour `from` of slot t by `to`.
void MeshEditor::relink(TriangleId t, TriangleId from, TriangleId to) {
  if (t == kNone) return;
  TriangleRecord& record = touch_triangle(t);
  for (TriangleId& neighbour : record.neighbours) {
    if (neighbour == from) {
      neighbour = to;
      return;
    }
  }
  KERF_CHECK(false, "adjacency is symmetric");
}

// Slot `from` has lost its corner at point p and vertex v. If p or v names it as its triangle, makes that slot `to`.
void MeshEditor::move_representative(TriangleId from, TriangleId to, PointId p, VertexId v) {
  if (mesh_.data_.points[p].triangle == from) touch_point(p).triangle = to;
  if (v != kNone && mesh_.data_.vertices[v].triangle == from) touch_vertex(v).triangle = to;
}

bool MeshEditor::respects_clearance(TriangleId t, const LatticePoint& p, int skipped_edge) const {
  for (int k = 0; k < 3; ++k) {
    if (k == skipped_edge || (mesh_.locks(t, k) & kLocksThatOpen) == 0) continue;
    const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
    const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
    const double length = std::hypot(static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y));
    if (static_cast<double>(doubled_area(a, b, p)) < static_cast<double>(kLockClearance) * length) return false;
  }
  return true;
}

PointId MeshEditor::split_triangle(TriangleId t, const LatticePoint& p) {
  const TriangleRecord old = mesh_.record(t);
  for (int k = 0; k < 3; ++k) {
    if (!is_positive(mesh_.at(old.points[next_corner(k)]), mesh_.at(old.points[previous_corner(k)]), p)) return kNone;
  }
  if (!respects_clearance(t, p, kNone) || !take_slots(2)) return kNone;

  const PointId added = add_point(p);
  const TriangleId first = mesh_.num_triangle_slots();
  const std::array<TriangleId, 3> child{t, first, first + 1};
  for (int k = 0; k < 3; ++k) {  // child k: corner k replaced by p
    TriangleRecord record = old;
    record.points[k] = added;
    record.vertices[k] = kNone;
    for (const int other : {next_corner(k), previous_corner(k)}) {
      record.neighbours[other] = child[other];
      record.locks[other] = 0;
    }
    if (k == 0) {
      touch_triangle(t) = record;
    } else {
      add_slot(record, t);
      relink(old.neighbours[k], t, child[k]);
    }
  }
  mesh_.data_.points[added].triangle = t;
  move_representative(t, child[1], old.points[0], old.vertices[0]);
  return added;
}

PointId MeshEditor::split_edge(TriangleId t, int k, const LatticePoint& p) {
  const TriangleId u = mesh_.welded_neighbour(t, k);
  if (u == kNone) return kNone;
  const int m = mesh_.mirror_corner(t, k);
  const TriangleRecord old_t = mesh_.record(t);
  const TriangleRecord old_u = mesh_.record(u);
  const int ka = next_corner(k), kb = previous_corner(k);  // corners a and b in t
  const int mb = next_corner(m), ma = previous_corner(m);  // corners b and a in u
  const LatticePoint &a = mesh_.at(old_t.points[ka]), &b = mesh_.at(old_t.points[kb]);
  const LatticePoint &c = mesh_.at(old_t.points[k]), &d = mesh_.at(old_u.points[m]);
  if (!is_positive(c, a, p) || !is_positive(c, p, b) || !is_positive(d, b, p) || !is_positive(d, p, a)) return kNone;
  if (!respects_clearance(t, p, k) || !respects_clearance(u, p, m) || !take_slots(2)) return kNone;

  const Lip lip = lip_of_edge(t, k);
  const PointId added = add_point(p);
  lips_.back() = lip;
  const TriangleId s = mesh_.num_triangle_slots();
  const TriangleId v = s + 1;

  TriangleRecord record = old_t;  // t = (c, a, p)
  record.points[kb] = added, record.vertices[kb] = kNone;
  record.neighbours[ka] = s, record.locks[ka] = 0;
  touch_triangle(t) = record;
  record = old_t;  // s = (c, p, b)
  record.points[ka] = added, record.vertices[ka] = kNone;
  record.neighbours[k] = v;
  record.neighbours[kb] = t, record.locks[kb] = 0;
  add_slot(record, t);
  record = old_u;  // u = (d, p, a)
  record.points[mb] = added, record.vertices[mb] = kNone;
  record.neighbours[ma] = v, record.locks[ma] = 0;
  touch_triangle(u) = record;
  record = old_u;  // v = (d, b, p)
  record.points[ma] = added, record.vertices[ma] = kNone;
  record.neighbours[m] = s;
  record.neighbours[mb] = u, record.locks[mb] = 0;
  add_slot(record, u);

  relink(old_t.neighbours[ka], t, s);
  relink(old_u.neighbours[ma], u, v);
  mesh_.data_.points[added].triangle = t;
  move_representative(t, s, old_t.points[kb], old_t.vertices[kb]);
  move_representative(u, v, old_u.points[mb], old_u.vertices[mb]);
  return added;
}

PointId MeshEditor::insert_point(const LatticePoint& p, TriangleId hint) {
  const Location location = mesh_.locate(p, hint);
  switch (location.kind) {
    case Location::Kind::kFace:
      return split_triangle(location.triangle, p);
    case Location::Kind::kEdge:
      return split_edge(location.triangle, location.corner, p);
    case Location::Kind::kPoint:
      return location.point;
    case Location::Kind::kOutside:
      break;
  }
  return kNone;
}

bool MeshEditor::flip_edge(TriangleId t, int k) {
  if (mesh_.is_fixed(t, k)) return false;
  const TriangleId u = mesh_.welded_neighbour(t, k);
  const int m = mesh_.mirror_corner(t, k);
  const TriangleRecord old_t = mesh_.record(t);
  const TriangleRecord old_u = mesh_.record(u);
  const int ka = next_corner(k), kb = previous_corner(k);
  const int mb = next_corner(m), ma = previous_corner(m);
  const LatticePoint &a = mesh_.at(old_t.points[ka]), &b = mesh_.at(old_t.points[kb]);
  const LatticePoint &c = mesh_.at(old_t.points[k]), &d = mesh_.at(old_u.points[m]);
  if (!is_positive(c, a, d) || !is_positive(d, b, c)) return false;

  TriangleRecord& new_t = touch_triangle(t);  // (c, a, d)
  new_t.points[kb] = old_u.points[m], new_t.vertices[kb] = old_u.vertices[m];
  new_t.neighbours[k] = old_u.neighbours[mb], new_t.locks[k] = old_u.locks[mb];
  new_t.neighbours[ka] = u, new_t.locks[ka] = 0;
  TriangleRecord& new_u = touch_triangle(u);  // (d, b, c)
  new_u.points[ma] = old_t.points[k], new_u.vertices[ma] = old_t.vertices[k];
  new_u.neighbours[m] = old_t.neighbours[ka], new_u.locks[m] = old_t.locks[ka];
  new_u.neighbours[mb] = t, new_u.locks[mb] = 0;

  relink(old_u.neighbours[mb], u, t);
  relink(old_t.neighbours[ka], t, u);
  move_representative(u, t, old_t.points[ka], old_u.vertices[ma]);
  move_representative(t, u, old_t.points[kb], old_t.vertices[kb]);
  return true;
}

bool MeshEditor::lock_edge(TriangleId t, int k, LockBits bits) {
  const TriangleId u = mesh_.welded_neighbour(t, k);
  if ((bits & kLockCut) != 0) {
    if (u == kNone || !mesh_.is_solid(t) || !mesh_.is_solid(u)) return false;
    if ((mesh_.locks(t, k) & kLockCut) == 0) {
      bits = static_cast<LockBits>(bits | kLockFresh);
      pending_.push_back(mesh_.points(t)[next_corner(k)]);
      pending_.push_back(mesh_.points(t)[previous_corner(k)]);
    }
  }
  LockBits& mine = touch_triangle(t).locks[k];
  mine = static_cast<LockBits>(mine | bits);
  if (u != kNone) {
    LockBits& mirrored = touch_triangle(u).locks[mesh_.mirror_corner(t, k)];
    mirrored = static_cast<LockBits>(mirrored | bits);
  }
  return true;
}

void MeshEditor::remove_triangles(const std::vector<TriangleId>& slots) {
  KERF_CHECK(new_vertices_.empty(), "material is removed before the edit is opened");
  for (const TriangleId t : slots) {
    TriangleRecord& record = touch_triangle(t);
    KERF_CHECK(record.region != kNone, "only solid slots are removed, each once");
    for (int k = 0; k < 3; ++k) {
      if (record.vertices[k] != kNone) orphaned_vertices_.push_back(record.vertices[k]);
      pending_.push_back(record.points[k]);
    }
    orphaned_pieces_.push_back(record.piece);
    record.region = record.piece = kNone;
    record.vertices = {kNone, kNone, kNone};
    --mesh_.data_.num_solid_triangles;
  }
  KERF_CHECK(mesh_.num_solid_triangles() > 0, "something of a sheet stays");
  for (const TriangleId t : slots) {
    for (int k = 0; k < 3; ++k) {
      const TriangleId u = mesh_.welded_neighbour(t, k);
      LockBits bits = 0;
      if (mesh_.is_solid(u)) {
        KERF_CHECK((mesh_.locks(t, k) & kLocksThatOpen) != 0, "what is removed ends at locked edges");
        bits = static_cast<LockBits>((mesh_.locks(t, k) & ~kLockCut) | kLockBorder);
      }
      touch_triangle(t).locks[k] = bits;
      touch_triangle(u).locks[mesh_.mirror_corner(t, k)] = bits;
    }
  }
}

bool MeshEditor::move_point(PointId p, const LatticePoint& to) {
  std::vector<TriangleId> fan;
  mesh_.fan_around(p, fan);
  for (const TriangleId t : fan) {
    const int c = mesh_.corner_of(t, p);
    if (mesh_.is_fixed(t, next_corner(c)) || mesh_.is_fixed(t, previous_corner(c))) return false;
    const std::array<PointId, 3>& corners = mesh_.points(t);
    if (!is_positive(to, mesh_.at(corners[next_corner(c)]), mesh_.at(corners[previous_corner(c)]))) return false;
    if (!respects_clearance(t, to, kNone)) return false;
  }
  if (!is_new(p) && !is_moved(p)) moved_.push_back(p);
  touch_point(p).at = to;
  return true;
}

}  // namespace kerf::mesh
