#include "server/cut/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/cut/lattice_geometry.h"
#include "server/cut/triangle_shape.h"

namespace kerf::cut {

using Eigen::Vector2d;
using mesh::kNone;
using mesh::LatticePoint;
using mesh::next_corner;
using mesh::PointId;
using mesh::previous_corner;
using mesh::TriangleId;

namespace {

constexpr int kSweeps = 3;
constexpr double kFirstStep = 0.35;  // -; reach of the first sweep, as a fraction of the mean ring radius; halves
constexpr double kWellShaped = 0.8;  // -; stars whose worst quality is above this are left alone
constexpr double kLeastImprovement = 0.02;  // -; in quality; smaller gains are not worth a changed rest position

// The ring around a free point, counter-clockwise, and the point itself.
struct Star {
  PointId centre = kNone;
  LatticePoint at;
  std::vector<LatticePoint> ring;
  std::vector<double> rim;     // squared lengths of the ring's edges, from each of its points to the next
  std::vector<double> spokes;  // squared distances of the ring's points from where the centre is tried

  // Quality of the worst triangle with the centre at p; at most 0 where one is not strictly positive. Of places that
  // are no better than `enough`, any value up to it.
  [[nodiscard]] double worst_quality(const LatticePoint& p, double enough) {
    const std::size_t size = ring.size();
    spokes.resize(size);
    for (std::size_t i = 0; i < size; ++i) spokes[i] = squared_distance(p, ring[i]);
    double worst = 1.0;
    for (std::size_t i = 0; i < size && worst > enough; ++i) {
      const std::size_t next = i + 1 == size ? 0 : i + 1;
      const double doubled_area = mesh::to_double(mesh::doubled_area(p, ring[i], ring[next]));
      if (doubled_area <= 0.0) return 0.0;
      worst = std::min(worst, quality_of(doubled_area, {rim[i], spokes[next], spokes[i]}));
    }
    return worst;
  }
};

LatticePoint moved(const LatticePoint& from, const Vector2d& by) {
  return {from.x + std::llround(by.x()), from.y + std::llround(by.y())};
}

// Places worth trying: the centre of the ring, and eight directions around where the point is.
std::array<LatticePoint, 9> trial_places(const Star& star, double reach) {
  Vector2d centre(0.0, 0.0);
  double radius = 0.0;
  for (const LatticePoint& p : star.ring) {
    const Vector2d offset = difference(star.at, p);
    centre += offset;
    radius += offset.norm();
  }
  const double count = static_cast<double>(star.ring.size());
  const double step = reach * radius / count;
  const double diagonal = step * std::sqrt(0.5);
  return {moved(star.at, centre / count),         moved(star.at, {step, 0.0}),
          moved(star.at, {diagonal, diagonal}),   moved(star.at, {0.0, step}),
          moved(star.at, {-diagonal, diagonal}),  moved(star.at, {-step, 0.0}),
          moved(star.at, {-diagonal, -diagonal}), moved(star.at, {0.0, -step}),
          moved(star.at, {diagonal, -diagonal})};
}

class Relaxation {
 public:
  Relaxation(mesh::MeshEditor& editor, std::span<const mesh::VertexId> fixed_vertices)
      : editor_(editor), mesh_(editor.mesh()), fixed_vertices_(fixed_vertices) {}

  // Whether p was moved.
  bool improve(PointId p, double reach) {
    if (!gather(p)) return false;
    double best_quality = star_.worst_quality(star_.at, 0.0);
    if (best_quality >= kWellShaped) return false;
    best_quality += kLeastImprovement;
    LatticePoint best = star_.at;
    for (const LatticePoint& place : trial_places(star_, reach)) {
      const double quality = star_.worst_quality(place, best_quality);
      if (quality <= best_quality) continue;
      best_quality = quality;
      best = place;
    }
    if (best == star_.at || !editor_.move_point(p, best)) return false;
    editor_.legalise(p);
    return true;
  }

 private:
  // Fills star_; false where p must stay.
  bool gather(PointId p) {
    if (editor_.is_new(p)) return false;
    star_.centre = p;
    star_.at = mesh_.at(p);
    star_.ring.clear();
    star_.rim.clear();
    mesh_.fan_around(p, fan_);
    for (const TriangleId t : fan_) {
      const int k = mesh_.corner_of(t, p);
      if (!mesh_.is_solid(t) || mesh_.is_fixed(t, next_corner(k)) || mesh_.is_fixed(t, previous_corner(k))) {
        return false;
      }
      const LatticePoint& from = mesh_.at(mesh_.points(t)[next_corner(k)]);
      star_.ring.push_back(from);
      star_.rim.push_back(squared_distance(from, mesh_.at(mesh_.points(t)[previous_corner(k)])));
    }
    const TriangleId first = fan_.front();
    const mesh::VertexId vertex = mesh_.vertices(first)[mesh_.corner_of(first, p)];
    return !std::binary_search(fixed_vertices_.begin(), fixed_vertices_.end(), vertex);
  }

  mesh::MeshEditor& editor_;
  const mesh::TriangleMesh& mesh_;
  std::span<const mesh::VertexId> fixed_vertices_;
  Star star_;
  std::vector<TriangleId> fan_;
};

}  // namespace

std::vector<PointId> relax(mesh::MeshEditor& editor, std::span<const PointId> candidates,
                           std::span<const mesh::VertexId> fixed_vertices) {
  Relaxation relaxation(editor, fixed_vertices);
  std::vector<PointId> changed;
  double reach = kFirstStep;
  for (int sweep = 0; sweep < kSweeps; ++sweep, reach *= 0.5) {
    for (const PointId p : candidates) {
      if (relaxation.improve(p, reach)) changed.push_back(p);
    }
  }
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  return changed;
}

}  // namespace kerf::cut
