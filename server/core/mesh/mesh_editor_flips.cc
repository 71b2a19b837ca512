// Flips that make triangles Delaunay around a new point, and flips that recover an edge.

#include <deque>

#include "server/base/check.h"
#include "server/core/mesh/mesh_editor.h"

namespace kerf::mesh {
namespace {

// Returns true if edge k of t is not locally Delaunay: the corner beyond it lies strictly inside the circumcircle of t.
bool is_encroached(const TriangleMesh& mesh, TriangleId t, int k) {
  const PointId across = mesh.points(mesh.welded_neighbour(t, k))[mesh.mirror_corner(t, k)];
  return mesh.is_in_circle(t, mesh.at(across));
}

}  // namespace

int MeshEditor::legalise(PointId p) {
  std::vector<TriangleId> stack;
  mesh_.fan_around(p, stack);
  int num_flips = 0;
  while (!stack.empty()) {  // each flip adds an edge at p, so there are fewer flips than points
    const TriangleId t = stack.back();
    stack.pop_back();
    const int k = mesh_.corner_of(t, p);
    if (k == kNone || mesh_.is_fixed(t, k) || !is_encroached(mesh_, t, k)) continue;
    const TriangleId u = mesh_.welded_neighbour(t, k);
    if (!flip_edge(t, k)) continue;
    ++num_flips;
    stack.push_back(u);
    stack.push_back(t);
  }
  return num_flips;
}

Recovery MeshEditor::recover_edge(PointId p, PointId q, LockBits locks) {
  const SegmentWalk walk = mesh_.walk_segment(p, q);
  Recovery result;
  std::vector<Edge> made;
  switch (walk.kind) {
    case SegmentWalk::Kind::kPoint:
      result.status = Recovery::Status::kPoint;
      result.point = walk.point;
      return result;
    case SegmentWalk::Kind::kFixedEdge:
      result.status = Recovery::Status::kFixedEdge;
      result.triangle = walk.triangle;
      result.corner = walk.corner;
      return result;
    case SegmentWalk::Kind::kEdgeExists:
      break;
    case SegmentWalk::Kind::kClear:
      if (!flip_crossed_edges(p, q, walk.crossed, made)) return result;
      break;
  }
  TriangleId t = mesh_.find_edge(p, q, result.corner);
  KERF_CHECK(t != kNone, "a segment that nothing crosses any more is an edge");
  if (locks != 0) lock_edge(t, result.corner, locks);
  if (!made.empty()) {
    // Flips only edges in `made`. The recovered edge is not among them, so it is not flipped away again, locked or not.
    legalise_edges(made);
    t = mesh_.find_edge(p, q, result.corner);
  }
  result.status = Recovery::Status::kRecovered;
  result.triangle = t;
  return result;
}

// Flips the edges that cross pq until none is left. Appends new edges that do not cross pq to `made`, without pq
// itself. Returns false after too many flips.
bool MeshEditor::flip_crossed_edges(PointId p, PointId q, const std::vector<Edge>& crossed, std::vector<Edge>& made) {
  std::deque<Edge> queue(crossed.begin(), crossed.end());
  const std::size_t k = queue.size();
  for (std::size_t budget = 20 * k * k + 200; !queue.empty(); --budget) {
    if (budget == 0) return false;
    const Edge edge = queue.front();
    queue.pop_front();
    int corner = 0;
    const TriangleId t = mesh_.find_edge(edge[0], edge[1], corner);
    KERF_DCHECK(t != kNone, "queued edges exist until they are flipped");
    const PointId apex = mesh_.points(t)[corner];
    const PointId across = mesh_.points(mesh_.welded_neighbour(t, corner))[mesh_.mirror_corner(t, corner)];
    if (!flip_edge(t, corner)) {
      queue.push_back(edge);  // the quad is not convex yet
      continue;
    }
    if ((apex == p && across == q) || (apex == q && across == p)) continue;
    if (segments_cross(mesh_.at(p), mesh_.at(q), mesh_.at(apex), mesh_.at(across))) {
      queue.push_back({apex, across});
    } else {
      made.push_back({apex, across});
    }
  }
  return true;
}

// Flips edges of `edges`, and the edges that replace them, until all are locally Delaunay. Edges with four points on
// one circle are not flipped, so each flip lowers the surface lifted to the paraboloid, and the loop ends. A limit on
// the number of flips makes that certain.
void MeshEditor::legalise_edges(std::vector<Edge>& edges) {
  std::size_t budget = 20 * edges.size() * edges.size() + 200;
  for (bool changed = true; changed;) {
    changed = false;
    for (Edge& edge : edges) {
      if (budget-- == 0) return;
      int corner = 0;
      const TriangleId t = mesh_.find_edge(edge[0], edge[1], corner);
      if (mesh_.is_fixed(t, corner) || !is_encroached(mesh_, t, corner)) continue;
      const PointId apex = mesh_.points(t)[corner];
      const PointId across = mesh_.points(mesh_.welded_neighbour(t, corner))[mesh_.mirror_corner(t, corner)];
      if (!flip_edge(t, corner)) continue;
      edge = {apex, across};
      changed = true;
    }
  }
}

}  // namespace kerf::mesh
