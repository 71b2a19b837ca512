#include "server/core/cut/join.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "server/core/cut/chord_tree.h"
#include "server/core/cut/nearby_lips.h"
#include "server/core/cut/segment_distance.h"

namespace kerf::cut {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

namespace {

constexpr double kLongestOfLine = 0.5;  // -; an end is led on by at most this share of its line's length
// An end runs over a line, and is not open, if it is not far from where it crossed that line. The limit is this times
// its distance from the nearest place. -
constexpr double kOvershoot = 4.0;
constexpr double kRounding = 1.0 + 1e-9;  // -; a gap as wide as the limit counts as closer
constexpr double kPreferEnd = 1.5;  // -; an open end that is at most so much farther than the nearest place is taken

Vector2d nearest_on_segment(const Vector2d& point, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? (point - a).dot(along) / squared : 0.0;
  if (t <= 0.0) return a;
  return t >= 1.0 ? b : a + t * along;
}

bool cross(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const auto side = [](const Vector2d& p, const Vector2d& q, const Vector2d& r) {
    return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
  };
  return side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
}

// Returns the distance from `from` to the place where segment ab meets cd, crossing it or coming closer than `touch`;
// infinity if it does not.
double meeting_distance(const Vector2d& from, const Vector2d& a, const Vector2d& b, const Vector2d& c,
                        const Vector2d& d, double touch) {
  if (cross(a, b, c, d)) {
    const Vector2d along = b - a;
    const Vector2d other = d - c;
    const double area = along.x() * other.y() - along.y() * other.x();
    const double t = ((c - a).x() * other.y() - (c - a).y() * other.x()) / area;
    return (a + std::clamp(t, 0.0, 1.0) * along - from).norm();
  }
  double least = std::numeric_limits<double>::infinity();
  for (const Vector2d& at : {a, b}) {
    if (distance_to_segment(at, c, d) <= touch) least = std::min(least, (at - from).norm());
  }
  for (const Vector2d& at : {c, d}) {
    if (distance_to_segment(at, a, b) <= touch) least = std::min(least, (at - from).norm());
  }
  return least;
}

// Returns b, or where the segment from a, which lies in the disc around `centre`, leaves the disc.
Vector2d within_disc(const Vector2d& centre, double radius, const Vector2d& a, const Vector2d& b) {
  if ((b - centre).norm() <= radius) return b;
  const Vector2d along = b - a;
  const Vector2d from = a - centre;
  const double half = from.dot(along);
  const double squared = along.squaredNorm();
  const double root = std::sqrt(std::max(0.0, half * half - squared * (from.squaredNorm() - radius * radius)));
  return a + std::clamp((root - half) / squared, 0.0, 1.0) * along;
}

AlignedBox2d box_around(const Vector2d& a, const Vector2d& b) {
  AlignedBox2d box(a);
  box.extend(b);
  return box;
}

// An end of a stroke that joins nothing yet.
struct OpenEnd {
  std::int32_t stroke = 0;
  bool at_front = false;
  bool is_done = false;  // It meets something, or was led on.
};

// Describes what is around the strokes.
struct Surroundings {
  NearbyLips* lips;                              // null: there is no sheet
  std::function<double(const Vector2d&)> near;   // m, distance below which an open end counts
  std::function<double(const Vector2d&)> touch;  // m, distance within which an end meets a line
};

class Joiner {
 public:
  Joiner(const Surroundings& around, const JoinOptions& options, std::vector<Stroke>& strokes)
      : around_(around), options_(options), strokes_(strokes), tree_(strokes) {}

  JoinReport run() {
    for (std::size_t s = 0; s < strokes_.size(); ++s) {
      const std::vector<Vector2d>& points = strokes_[s].points;
      double length = 0.0;
      for (std::size_t i = 0; i + 1 < points.size(); ++i) length += (points[i + 1] - points[i]).norm();
      lengths_.push_back(length);
      if (points.front() == points.back()) continue;
      for (const bool at_front : {true, false}) {
        ends_.push_back({static_cast<std::int32_t>(s), at_front});
        ends_.back().is_done = is_kept(place(ends_.back()));
      }
    }
    for (std::size_t e = 0; e < ends_.size(); ++e) {
      if (!ends_[e].is_done) look_at(e);
    }
    for (auto& [end, to] : joins_) lead_on(end, to);
    return report_;
  }

 private:
  struct Place {
    Vector2d at{0.0, 0.0};
    double distance = std::numeric_limits<double>::infinity();  // m
    std::int32_t stroke = -1;                                   // -1: a lip or the border
  };

  [[nodiscard]] const std::vector<Vector2d>& points_of(std::int32_t stroke) const {
    return strokes_[static_cast<std::size_t>(stroke)].points;
  }
  [[nodiscard]] const Vector2d& place(const OpenEnd& end) const {
    const std::vector<Vector2d>& points = points_of(end.stroke);
    return end.at_front ? points.front() : points.back();
  }
  [[nodiscard]] bool is_kept(const Vector2d& at) const {
    return std::binary_search(options_.kept_ends.begin(), options_.kept_ends.end(), at, before);
  }
  static bool before(const Vector2d& a, const Vector2d& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); }

  // Sets tail_: the chords of the end's own line up to where it first leaves the disc of `radius` around the end.
  void find_tail(const OpenEnd& end, double radius) {
    const std::vector<Vector2d>& points = points_of(end.stroke);
    const auto count = static_cast<std::int32_t>(points.size()) - 1;
    tail_ = 0;
    while (tail_ < count) {
      ++tail_;
      const std::int32_t at = end.at_front ? tail_ : count - tail_;
      if ((points[static_cast<std::size_t>(at)] - place(end)).norm() > radius) break;
    }
  }
  [[nodiscard]] bool is_tail(const OpenEnd& end, const ChordTree::Chord& chord) const {
    if (chord.stroke != end.stroke) return false;
    const auto count = static_cast<std::int32_t>(points_of(end.stroke).size()) - 1;
    return end.at_front ? chord.index < tail_ : chord.index >= count - tail_;
  }

  // Returns the distance from the end to where its line meets a lip, the border or another line within `radius`;
  // infinity if it meets none.
  [[nodiscard]] double distance_to_meeting(const OpenEnd& end, double radius, double touch,
                                           const std::vector<std::array<Vector2d, 2>>& lips) const {
    const std::vector<Vector2d>& points = points_of(end.stroke);
    const auto count = static_cast<std::int32_t>(points.size()) - 1;
    const std::int32_t after_tail = end.at_front ? tail_ : count - tail_ - 1;
    const Vector2d& from = place(end);
    double least = std::numeric_limits<double>::infinity();
    for (std::int32_t i = 0; i < tail_ && least > radius; ++i) {
      const Vector2d& a = points[static_cast<std::size_t>(end.at_front ? i : count - i)];
      const Vector2d& beyond = points[static_cast<std::size_t>(end.at_front ? i + 1 : count - i - 1)];
      const Vector2d b = within_disc(from, radius, a, beyond);
      const auto meet = [&](const Vector2d& c, const Vector2d& d) {
        least = std::min(least, meeting_distance(from, a, b, c, d, touch));
      };
      for (const auto& lip : lips) meet(lip[0], lip[1]);
      tree_.for_each_near(box_around(a, b), touch, [&](const ChordTree::Chord& chord) {
        // The chord that follows the tail begins where it ends.
        const bool is_own = is_tail(end, chord) || (chord.stroke == end.stroke && chord.index == after_tail);
        const std::vector<Vector2d>& other = points_of(chord.stroke);
        const auto at = static_cast<std::size_t>(chord.index);
        if (!is_own) meet(other[at], other[at + 1]);
        return true;
      });
    }
    return least;
  }

  [[nodiscard]] Place nearest(const OpenEnd& end, double radius,
                              const std::vector<std::array<Vector2d, 2>>& lips) const {
    const Vector2d& from = place(end);
    Place best;
    const auto take = [&](const Vector2d& a, const Vector2d& b, std::int32_t stroke) {
      const Vector2d at = nearest_on_segment(from, a, b);
      const double distance = (at - from).norm();
      if (distance < best.distance || (distance == best.distance && before(at, best.at))) best = {at, distance, stroke};
    };
    for (const auto& lip : lips) take(lip[0], lip[1], -1);
    tree_.for_each_near(AlignedBox2d(from), radius, [&](const ChordTree::Chord& chord) {
      const std::vector<Vector2d>& other = points_of(chord.stroke);
      const auto at = static_cast<std::size_t>(chord.index);
      if (!is_tail(end, chord)) take(other[at], other[at + 1], chord.stroke);
      return true;
    });
    return best;
  }

  // Returns the open ends of a stroke as a range of ends_.
  [[nodiscard]] std::pair<std::size_t, std::size_t> ends_of(std::int32_t stroke) const {
    const auto is_before = [](const OpenEnd& end, std::int32_t wanted) { return end.stroke < wanted; };
    const auto first =
        static_cast<std::size_t>(std::lower_bound(ends_.begin(), ends_.end(), stroke, is_before) - ends_.begin());
    std::size_t last = first;
    while (last < ends_.size() && ends_[last].stroke == stroke) ++last;
    return {first, last};
  }

  // Returns the index of the nearest open end, no farther than `radius` from end `e`.
  [[nodiscard]] std::optional<std::size_t> nearest_end(std::size_t e, double radius) const {
    const Vector2d& from = place(ends_[e]);
    std::optional<std::size_t> best;
    double least = radius;
    tree_.for_each_near(AlignedBox2d(from), radius, [&](const ChordTree::Chord& chord) {
      const auto [first, last] = ends_of(chord.stroke);
      for (std::size_t other = first; other < last; ++other) {
        const double distance = (place(ends_[other]) - from).norm();
        if (other == e || ends_[other].is_done || distance > least) continue;
        if (distance == least && best && *best <= other) continue;
        best = other;
        least = distance;
      }
      return true;
    });
    return best;
  }

  void look_at(std::size_t e) {
    OpenEnd& end = ends_[e];
    const Vector2d from = place(end);
    end.is_done = true;
    if (around_.lips != nullptr && !around_.lips->is_on_sheet(from)) return;
    const double longest = kLongestOfLine * lengths_[static_cast<std::size_t>(end.stroke)];
    const double join = std::min(kRounding * options_.distance, longest);
    const double near = std::min(kRounding * around_.near(from), longest);
    const double radius = std::max(join, near);
    const std::vector<std::array<Vector2d, 2>> none;
    const auto& lips = around_.lips != nullptr ? around_.lips->near(from, radius) : none;
    find_tail(end, radius);
    const double touch = kRounding * std::max(around_.touch(from), options_.covered);
    Place best = nearest(end, radius, lips);
    if (best.distance <= touch || best.distance > radius) return;
    if (distance_to_meeting(end, radius, touch, lips) <= kOvershoot * best.distance) return;
    if (best.distance < join) {
      const std::optional<std::size_t> other = nearest_end(e, std::min(join, kPreferEnd * best.distance));
      if (other) {
        best = {place(ends_[*other]), (place(ends_[*other]) - from).norm(), ends_[*other].stroke};
      }
      joins_.emplace_back(end, best.at);
      ++report_.joined_ends;
      report_.widest_join_m = std::max(report_.widest_join_m, best.distance);
      finish_ends_at(best, radius);
    } else if (best.distance < near) {
      if (report_.near_ends == 0 || best.distance < report_.nearest_end_m) report_.nearest_end_m = best.distance;
      ++report_.near_ends;
    }
  }

  // Marks ends of the line that was met, if the place is beside them.
  void finish_ends_at(const Place& met, double radius) {
    if (met.stroke < 0) return;
    const auto [first, last] = ends_of(met.stroke);
    for (std::size_t e = first; e < last; ++e) {
      if ((place(ends_[e]) - met.at).norm() <= radius) ends_[e].is_done = true;
    }
  }

  void lead_on(const OpenEnd& end, const Vector2d& to) {
    std::vector<Vector2d>& points = strokes_[static_cast<std::size_t>(end.stroke)].points;
    points.insert(end.at_front ? points.begin() : points.end(), to);
  }

  const Surroundings& around_;
  const JoinOptions& options_;
  std::vector<Stroke>& strokes_;
  ChordTree tree_;
  std::vector<double> lengths_;  // m, of the strokes
  std::vector<OpenEnd> ends_;    // by stroke
  std::int32_t tail_ = 0;        // number of chords in the tail of the present end
  std::vector<std::pair<OpenEnd, Vector2d>> joins_;
  JoinReport report_;
};

}  // namespace

JoinReport join_ends(const mesh::TriangleMesh& mesh, const PathScale& scale, const JoinOptions& options,
                     std::vector<Stroke>& strokes) {
  NearbyLips lips(mesh, kMaxTrianglesPerCut);
  const Surroundings around{&lips, [&scale](const Vector2d& at) { return kNearEnd * scale.edge_length(at); },
                            [&scale](const Vector2d& at) { return scale.snap(at); }};
  return Joiner(around, options, strokes).run();
}

JoinReport near_ends(std::vector<Stroke> strokes, double distance, std::vector<Vector2d> kept_ends) {
  const Surroundings around{nullptr, [distance](const Vector2d& /*at*/) { return distance; },
                            [distance](const Vector2d& /*at*/) { return 1e-3 * distance; }};
  return Joiner(around, {0.0, 0.0, std::move(kept_ends)}, strokes).run();
}

std::vector<Vector2d> kept_ends(const Curve& curve) {
  std::vector<Vector2d> kept;
  const auto* path = std::get_if<Path>(&curve);
  if (path == nullptr) return kept;
  for (const Subpath& line : path->subpaths) {
    const auto* first = std::get_if<LineTo>(&line.segments.front());
    if (first != nullptr && first->end == line.start) kept.push_back(line.start);
    if (line.segments.size() < 2) continue;
    const auto end = [](const Segment& segment) {
      return std::visit([](const auto& each) -> Vector2d { return each.end; }, segment);
    };
    const bool is_line = std::holds_alternative<LineTo>(line.segments.back());
    const Vector2d last = end(line.segments.back());
    if (is_line && last == end(line.segments[line.segments.size() - 2])) kept.push_back(last);
  }
  std::sort(kept.begin(), kept.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  return kept;
}

}  // namespace kerf::cut
