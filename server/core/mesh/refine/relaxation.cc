#include "server/core/mesh/refine/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/base/interruption.h"
#include "server/base/sort_unique.h"
#include "server/core/mesh/lattice_geometry.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::mesh {

using Eigen::Vector2d;

namespace {

constexpr int kSweeps = 3;
constexpr double kFirstStep = 0.35;  // -; length of a trial step over the mean distance of the neighbours; halves with
                                     // each sweep
constexpr double kLeastImprovement = 0.02;  // -; in quality; smaller gains are not worth a changed rest position

// The ring around a free point, counter-clockwise, seen from the point. Lattice units.
struct Star {
  std::vector<Vector2d> ring;
  std::vector<double> rim;       // squared lengths of the ring's edges, from each of its points to the next
  std::vector<Vector2d> spokes;  // the ring and again its first point, relative to the trial place
  std::size_t critical = 0;      // index of the triangle that ended the last comparison, and is likely to end the next

  // Returns the quality of the worst triangle if the point moves to p; at most 0 if a triangle is not positive. May
  // return any value up to `enough` if the quality is not above `enough`.
  [[nodiscard]] double worst_quality(const Vector2d& p, double enough) {
    const std::size_t size = ring.size();
    spokes.resize(size + 1);
    for (std::size_t i = 0; i < size; ++i) spokes[i] = ring[i] - p;
    spokes[size] = spokes[0];
    double worst = 1.0;
    std::size_t i = critical;
    for (std::size_t n = 0; n < size; ++n) {
      const Vector2d& a = spokes[i];
      const Vector2d& b = spokes[i + 1];
      const double doubled_area = a.x() * b.y() - a.y() * b.x();
      worst = std::min(worst, quality_of(doubled_area, rim[i] + a.squaredNorm() + b.squaredNorm()));
      if (worst <= enough) {
        critical = i;
        break;
      }
      i = i + 1 == size ? 0 : i + 1;
    }
    return worst;
  }
};

Vector2d rounded(const Vector2d& p) {
  return {std::nearbyint(p.x()), std::nearbyint(p.y())};
}

// Returns the places to try: the centre of the ring, and steps in eight directions from the point.
std::array<Vector2d, 9> trial_places(const Star& star, double reach) {
  Vector2d centre(0.0, 0.0);
  double radius = 0.0;
  for (const Vector2d& p : star.ring) {
    centre += p;
    radius += p.norm();
  }
  const double count = static_cast<double>(star.ring.size());
  const double step = std::nearbyint(reach * radius / count);
  const double diagonal = std::nearbyint(step * std::sqrt(0.5));
  return {rounded(centre / count),       Vector2d(step, 0.0),  Vector2d(diagonal, diagonal),   Vector2d(0.0, step),
          Vector2d(-diagonal, diagonal), Vector2d(-step, 0.0), Vector2d(-diagonal, -diagonal), Vector2d(0.0, -step),
          Vector2d(diagonal, -diagonal)};
}

class Relaxation {
 public:
  Relaxation(MeshEditor& editor, std::span<const VertexId> fixed_vertices, double well_shaped)
      : editor_(editor), mesh_(editor.mesh()), fixed_vertices_(fixed_vertices), well_shaped_(well_shaped) {}

  // Moves p to the trial place at which the worst triangle around it is best, then legalises the edges around it.
  // Returns false, and changes nothing, if p must stay, its triangles are well shaped, or no place is better by more
  // than kLeastImprovement.
  bool improve(PointId p, double reach) {
    if (!gather(p)) return false;
    const Vector2d here = Vector2d::Zero();
    double best_quality = star_.worst_quality(here, 0.0);
    if (best_quality >= well_shaped_) return false;
    best_quality += kLeastImprovement;
    Vector2d best = here;
    for (const Vector2d& place : trial_places(star_, reach)) {
      const double quality = star_.worst_quality(place, best_quality);
      if (quality <= best_quality) continue;
      best_quality = quality;
      best = place;
    }
    if (best == here) return false;
    const LatticePoint& at = mesh_.at(p);
    if (!editor_.move_point(p, {at.x + std::llround(best.x()), at.y + std::llround(best.y())})) return false;
    editor_.legalise(p);
    return true;
  }

 private:
  // Fills star_. Returns false if p must stay.
  bool gather(PointId p) {
    const LatticePoint& at = mesh_.at(p);
    star_.ring.clear();
    star_.rim.clear();
    star_.critical = 0;
    const TriangleId first = mesh_.triangle_at_point(p);
    for (TriangleId t = first;;) {
      const int k = mesh_.corner_of(t, p);
      const TriangleId next = mesh_.welded_neighbour(t, next_corner(k));
      if (!mesh_.is_solid(t) || mesh_.is_fixed(t, next_corner(k))) return false;
      star_.ring.push_back(difference(at, mesh_.at(mesh_.points(t)[next_corner(k)])));
      t = next;
      if (t == first) break;
    }
    for (std::size_t i = 0; i < star_.ring.size(); ++i) {
      const std::size_t next = i + 1 == star_.ring.size() ? 0 : i + 1;
      star_.rim.push_back((star_.ring[next] - star_.ring[i]).squaredNorm());
    }
    const VertexId vertex = mesh_.vertices(first)[mesh_.corner_of(first, p)];
    return !std::binary_search(fixed_vertices_.begin(), fixed_vertices_.end(), vertex);
  }

  MeshEditor& editor_;
  const TriangleMesh& mesh_;
  std::span<const VertexId> fixed_vertices_;
  double well_shaped_;
  Star star_;
};

}  // namespace

std::vector<PointId> relax(MeshEditor& editor, std::span<const PointId> candidates,
                           std::span<const VertexId> fixed_vertices, double well_shaped) {
  Relaxation relaxation(editor, fixed_vertices, well_shaped);
  std::vector<PointId> changed;
  double reach = kFirstStep;
  for (int sweep = 0; sweep < kSweeps; ++sweep, reach *= 0.5) {
    for (const PointId p : candidates) {
      interruption_point();
      if (relaxation.improve(p, reach)) changed.push_back(p);
    }
  }
  sort_unique(changed);
  return changed;
}

}  // namespace kerf::mesh
