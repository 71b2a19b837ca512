#include "server/core/contact/untangling.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

namespace kerf::contact {

using mesh::VertexId;

namespace {

constexpr double kPullSpeed = 0.05;          // m/s, largest speed at which an edge is pulled out of a triangle
constexpr double kPullAcceleration = 100.0;  // m/s^2, at which it gains that speed
constexpr double kClear = 0.1;               // -, of the thickness: distance at which an edge has left
constexpr double kMargin = 0.25;  // -, in barycentric coordinates: how far beside a triangle an edge is still pulled

}  // namespace

void Untangling::set(const SheetFeatures& features) {
  triangles_.clear();
  for (const SheetFeatures::Triangle& triangle : features.triangles) triangles_.push_back(triangle.vertices);
  is_known_ = false;
  pairs_.clear();
  pushes_.clear();
}

void Untangling::search(const linear::VertexField& x) {
  const auto is_same = [&] {
    return x_known_.cols() == x.cols() && std::equal(x.data(), x.data() + x.size(), x_known_.data());
  };
  if (is_known_ && is_same()) return;
  pairs_ = search_.find(triangles_, x, std::numeric_limits<std::size_t>::max()).pairs;
  x_known_ = x;
  is_known_ = true;
}

std::int64_t Untangling::count(const linear::VertexField& x) {
  search(x);
  return static_cast<std::int64_t>(pairs_.size());
}

void Untangling::know_none(const linear::VertexField& x) {
  pairs_.clear();
  x_known_ = x;
  is_known_ = true;
}

void Untangling::begin(const SheetFeatures& features, const linear::VertexField& x) {
  search(x);
  pushes_.clear();
  if (empty()) return;
  contours_.find(features, pairs_, x, piercings_);
  list_open(features);
}

void Untangling::list_open(const SheetFeatures& features) {
  open_pairs_.clear();
  for (const auto& [t, u] : pairs_) {
    for (const VertexId v : features.triangles[static_cast<std::size_t>(t)].vertices) {
      for (const VertexId w : features.triangles[static_cast<std::size_t>(u)].vertices) {
        open_pairs_.push_back({v, w});
        open_pairs_.push_back({w, v});
      }
    }
  }
  std::sort(open_pairs_.begin(), open_pairs_.end());
  open_pairs_.erase(std::unique(open_pairs_.begin(), open_pairs_.end()), open_pairs_.end());
  first_open_.assign(static_cast<std::size_t>(x_known_.cols()) + 1, 0);
  open_.clear();
  for (const auto& [v, w] : open_pairs_) {
    ++first_open_[static_cast<std::size_t>(v) + 1];
    open_.push_back(w);
  }
  for (std::size_t v = 1; v < first_open_.size(); ++v) first_open_[v] += first_open_[v - 1];
}

bool Untangling::is_open(const FeaturePair& pair) const {
  for (std::size_t i = 0; i < pair.num_a(); ++i) {
    const auto v = static_cast<std::size_t>(pair.vertices[i]);
    const auto begin = open_.begin() + first_open_[v], end = open_.begin() + first_open_[v + 1];
    if (begin == end) continue;
    for (std::size_t j = pair.num_a(); j < 4; ++j) {
      if (std::binary_search(begin, end, pair.vertices[j])) return true;
    }
  }
  return false;
}

void Untangling::find_pushes(const SheetFeatures& features, const linear::VertexField& x, const linear::VertexField& v,
                             double thickness, double interval, ImpulseResponse& response) {
  pushes_.clear();
  if (empty()) return;
  const double clear = kClear * thickness;
  for (const Piercing& of : piercings_) {
    if (of.way.isZero(0.0)) continue;
    const auto& [p, q] = features.edges[static_cast<std::size_t>(of.edge)].vertices;
    const auto& [a, b, c] = features.triangles[static_cast<std::size_t>(of.triangle)].vertices;
    const Eigen::Vector3d from = x.col(a), ab = x.col(b) - x.col(a), ac = x.col(c) - x.col(a);
    const Eigen::Vector3d normal = ab.cross(ac);
    // m, on the side to which the edge leaves
    const double size = normal.dot(of.way) < 0.0 ? -normal.norm() : normal.norm();
    const double height_p = normal.dot(x.col(p) - from) / size, height_q = normal.dot(x.col(q) - from) / size;
    const double low = std::min(height_p, height_q);
    if (!(std::max(height_p, height_q) > 0.0 && low < clear)) continue;
    // The point that edge and triangle share, or the nearer end of an edge that has only just left.
    const double s = low < 0.0 ? height_p / (height_p - height_q) : height_p > height_q ? 1.0 : 0.0;
    const Eigen::Vector3d point = (1.0 - s) * x.col(p) + s * x.col(q) - from;
    std::array<double, 3> place{0.0, point.cross(ac).dot(normal) / (size * size),
                                ab.cross(point).dot(normal) / (size * size)};
    place[0] = 1.0 - place[1] - place[2];
    if (!(*std::min_element(place.begin(), place.end()) > -kMargin)) continue;
    for (double& each : place) each = std::max(each, 0.0);
    const double sum = place[0] + place[1] + place[2];
    Push push;
    push.vertices = {p, q, a, b, c};
    push.weights = {1.0 - s, s, -place[0] / sum, -place[1] / sum, -place[2] / sum};
    push.way = of.way;
    const double mobility = response.mobility(push.vertices, push.weights, push.way);
    if (!(mobility > 0.0)) continue;
    push.mass = 1.0 / mobility;
    push.target = std::min(kPullSpeed, std::max(push.speed_at(v), 0.0) + kPullAcceleration * interval);
    if (low >= 0.0) push.target = std::min(push.target, (clear - low) / interval);
    pushes_.push_back(push);
  }
}

}  // namespace kerf::contact
