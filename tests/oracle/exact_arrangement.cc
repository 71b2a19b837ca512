#include "tests/oracle/exact_arrangement.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <boost/multiprecision/cpp_int.hpp>

#include "tests/audit/box_grid.h"
#include "tests/audit/union_find.h"

namespace kerf::oracle {
namespace {

using audit::UnionFind;
using Box = Eigen::AlignedBox2d;
using mesh::LatticePoint;
using mesh::TriangleRecord;

__extension__ using Wide = __int128;  // holds every product of two coordinates, and sums of four
using Exact = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<
    256, 256, boost::multiprecision::signed_magnitude, boost::multiprecision::unchecked, void>>;

std::size_t index(std::int32_t id) {
  return static_cast<std::size_t>(id);
}

Wide area(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return Wide{b.x - a.x} * (c.y - a.y) - Wide{b.y - a.y} * (c.x - a.x);
}

// A quotient with a positive denominator.
struct Ratio {
  Wide numerator = 0;
  Wide denominator = 1;

  Ratio(Wide n, Wide d) : numerator(d < 0 ? -n : n), denominator(d < 0 ? -d : d) {}
};

double to_double(const Ratio& ratio) {
  return static_cast<double>(ratio.numerator) / static_cast<double>(ratio.denominator);
}

int compare(const Ratio& a, const Ratio& b) {
  const double x = to_double(a);
  const double y = to_double(b);
  if (std::abs(x - y) > 1e-12 * (std::abs(x) + std::abs(y))) return x < y ? -1 : 1;
  const Exact left = Exact(a.numerator) * Exact(b.denominator);
  const Exact right = Exact(b.numerator) * Exact(a.denominator);
  return left.compare(right);
}

class Arrangement {
 public:
  Arrangement(const mesh::TriangleMesh& sheet, const std::vector<cut::Stroke>& strokes, double clearance)
      : data_(sheet.data()), search_(clearance), clearance_(clearance) {
    add_edges([](const TriangleRecord& r, std::size_t k) { return r.locks[k] != 0; });
    num_locks_ = segments_.size();
    add_edges([&](const TriangleRecord& r, std::size_t k) { return r.locks[k] == 0 && is_between_regions(r, k); });
    first_path_ = segments_.size();
    add_strokes(strokes);
  }

  Outcome run() {
    cross_all();
    UnionFind nodes(num_nodes_);
    for (Segment& segment : segments_) sort_and_merge(segment, nodes);
    std::set<std::pair<std::size_t, std::size_t>> edges;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      if (i >= num_locks_ && i < first_path_) continue;
      const bool is_path = i >= first_path_;
      const std::vector<Ratio> border = is_path ? border_crossings(segments_[i]) : std::vector<Ratio>{};
      const std::vector<Event>& events = segments_[i].events;
      for (std::size_t k = 0; k + 1 < events.size(); ++k) {
        const std::size_t u = nodes.root(events[k].node);
        const std::size_t v = nodes.root(events[k + 1].node);
        if (u == v || (is_path && !is_inside(events[k].at, border))) continue;
        edges.insert(std::minmax(u, v));
      }
    }
    return count(edges);
  }

  [[nodiscard]] double clearance() const { return clearance_; }

 private:
  struct Event {
    Ratio at;  // along the segment, 0 at a, 1 at b
    std::size_t node;
  };
  struct Segment {
    LatticePoint a, b;
    bool is_border;
    std::vector<Event> events;
  };

  std::size_t node_at(const LatticePoint& p) {
    const auto [entry, is_new] = node_at_.try_emplace(p, num_nodes_);
    if (is_new) ++num_nodes_;
    return entry->second;
  }

  void add_segment(const LatticePoint& a, const LatticePoint& b, bool is_border) {
    segments_.push_back({a, b, is_border, {{Ratio(0, 1), node_at(a)}, {Ratio(1, 1), node_at(b)}}});
  }

  [[nodiscard]] bool is_between_regions(const TriangleRecord& r, std::size_t k) const {
    return r.neighbours[k] != mesh::kNone && data_.triangles[index(r.neighbours[k])].region != r.region;
  }

  // Adds the edges that `is_wanted(triangle, corner)` picks, each once.
  template <typename Wanted>
  void add_edges(const Wanted& is_wanted) {
    for (std::size_t t = 0; t < data_.triangles.size(); ++t) {
      const TriangleRecord& r = data_.triangles[t];
      for (std::size_t k = 0; k < 3; ++k) {
        if (!is_wanted(r, k) || index(r.neighbours[k]) < t) continue;
        add_segment(data_.points[index(r.points[(k + 1) % 3])].at, data_.points[index(r.points[(k + 2) % 3])].at,
                    (r.locks[k] & mesh::kLockBorder) != 0);
      }
    }
  }

  void add_strokes(const std::vector<cut::Stroke>& strokes) {
    const mesh::Lattice& lattice = data_.lattice;
    const auto rounded = [&](const Eigen::Vector2d& p) {
      return LatticePoint{std::llrint((p.x() - lattice.origin.x()) / lattice.spacing),
                          std::llrint((p.y() - lattice.origin.y()) / lattice.spacing)};
    };
    for (const cut::Stroke& stroke : strokes) {
      for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
        const LatticePoint a = rounded(stroke.points[i]);
        const LatticePoint b = rounded(stroke.points[i + 1]);
        if (a != b) add_segment(a, b, false);
      }
    }
  }

  static Box box_of(const Segment& s) {
    Box box;
    for (const LatticePoint& p : {s.a, s.b}) {
      box.extend(Eigen::Vector2d(static_cast<double>(p.x), static_cast<double>(p.y)));
    }
    return box;
  }

  // Edges of the mesh meet in their ends only, so only pairs with the path count.
  void cross_all() {
    std::vector<Box> boxes;
    boxes.reserve(segments_.size());
    for (const Segment& segment : segments_) boxes.push_back(box_of(segment));
    audit::BoxGrid grid(boxes);
    for (std::size_t i = first_path_; i < segments_.size(); ++i) {
      Box around = boxes[i];
      around.min().array() -= search_;
      around.max().array() += search_;
      grid.for_touching(around, [&](std::size_t j) {
        if (j < i) cross(segments_[i], segments_[j]);
      });
    }
  }

  void note_distance(const Segment& segment, const LatticePoint& p, const Wide& doubled_area) {
    const auto offset = [](const LatticePoint& from, const LatticePoint& to) {
      return Eigen::Vector2d(static_cast<double>(to.x - from.x), static_cast<double>(to.y - from.y));
    };
    const Eigen::Vector2d along = offset(segment.a, segment.b);
    const double t = offset(segment.a, p).dot(along) / along.squaredNorm();
    double distance = std::abs(static_cast<double>(doubled_area)) / along.norm();
    if (t < 0.0 || t > 1.0) distance = std::min(offset(segment.a, p).norm(), offset(segment.b, p).norm());
    if (distance > 0.0) clearance_ = std::min(clearance_, distance);
  }

  // Adds p, an end of another segment on the line of this one, where it is on the segment.
  void touch(Segment& segment, const LatticePoint& p) {
    const Wide along =
        Wide{p.x - segment.a.x} * (segment.b.x - segment.a.x) + Wide{p.y - segment.a.y} * (segment.b.y - segment.a.y);
    const Wide whole = Wide{segment.b.x - segment.a.x} * (segment.b.x - segment.a.x) +
                       Wide{segment.b.y - segment.a.y} * (segment.b.y - segment.a.y);
    if (along >= 0 && along <= whole) segment.events.push_back({Ratio(along, whole), node_at(p)});
  }

  void cross(Segment& s, Segment& t) {
    const Wide ta = area(s.a, s.b, t.a), tb = area(s.a, s.b, t.b);
    const Wide sa = area(t.a, t.b, s.a), sb = area(t.a, t.b, s.b);
    note_distance(s, t.a, ta);
    note_distance(s, t.b, tb);
    note_distance(t, s.a, sa);
    note_distance(t, s.b, sb);
    if (ta == 0) touch(s, t.a);
    if (tb == 0) touch(s, t.b);
    if (sa == 0) touch(t, s.a);
    if (sb == 0) touch(t, s.b);
    const auto opposite = [](Wide x, Wide y) { return (x < 0 && y > 0) || (x > 0 && y < 0); };
    if (!opposite(ta, tb) || !opposite(sa, sb)) return;
    s.events.push_back({Ratio(sa, sa - sb), num_nodes_});
    t.events.push_back({Ratio(ta, ta - tb), num_nodes_});
    ++num_nodes_;
  }

  void sort_and_merge(Segment& segment, UnionFind& nodes) {
    const double length =
        std::hypot(static_cast<double>(segment.b.x - segment.a.x), static_cast<double>(segment.b.y - segment.a.y));
    std::vector<Event>& events = segment.events;
    std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return compare(a.at, b.at) < 0; });
    for (std::size_t k = 0; k + 1 < events.size(); ++k) {
      if (compare(events[k].at, events[k + 1].at) == 0) {
        nodes.join(events[k].node, events[k + 1].node);
      } else {
        clearance_ = std::min(clearance_, length * (to_double(events[k + 1].at) - to_double(events[k].at)));
      }
    }
  }

  // Returns where the whole line of a segment crosses the border, each crossing counted once. An end of a border edge
  // that is on the line counts as left of it.
  [[nodiscard]] std::vector<Ratio> border_crossings(const Segment& segment) const {
    std::vector<Ratio> crossings;
    for (std::size_t j = 0; j < num_locks_; ++j) {
      const Segment& edge = segments_[j];
      if (!edge.is_border) continue;
      if ((area(segment.a, segment.b, edge.a) >= 0) == (area(segment.a, segment.b, edge.b) >= 0)) continue;
      const Wide from = area(edge.a, edge.b, segment.a);
      crossings.emplace_back(from, from - area(edge.a, edge.b, segment.b));
    }
    return crossings;
  }

  // True if the stretch of a path that begins at `start`, with no border inside it, lies in the sheet: an odd number of
  // crossings lies ahead.
  static bool is_inside(const Ratio& start, const std::vector<Ratio>& border) {
    return std::count_if(border.begin(), border.end(), [&](const Ratio& at) { return compare(at, start) > 0; }) % 2 ==
           1;
  }

  [[nodiscard]] Outcome count(const std::set<std::pair<std::size_t, std::size_t>>& edges) const {
    std::map<std::size_t, int> degree;
    UnionFind parts(num_nodes_);
    std::int64_t joined = 0;
    for (const auto& [u, v] : edges) {
      ++degree[u];
      ++degree[v];
      if (parts.join(u, v)) ++joined;
    }
    const auto num_nodes = static_cast<std::int64_t>(degree.size());
    const auto num_edges = static_cast<std::int64_t>(edges.size());
    const std::int64_t num_parts = num_nodes - joined;
    Outcome outcome;
    outcome.pieces = num_edges - num_nodes + num_parts + 1 - void_parts();
    outcome.characteristic = solid_characteristic() - num_nodes + num_edges;
    for (const auto& [node, edges_there] : degree) {
      if (edges_there == 2) continue;
      ++outcome.places[edges_there == 1 ? 0U : static_cast<std::size_t>(std::min(edges_there, 5) - 2)];
    }
    return outcome;
  }

  [[nodiscard]] std::int64_t void_parts() const {
    UnionFind parts(data_.triangles.size());
    std::int64_t count = 0;
    for (std::size_t t = 0; t < data_.triangles.size(); ++t) {
      const TriangleRecord& r = data_.triangles[t];
      if (r.region >= 0) continue;
      ++count;
      for (const mesh::TriangleId n : r.neighbours) {
        if (n != mesh::kNone && index(n) < t && data_.triangles[index(n)].region < 0 && parts.join(t, index(n)))
          --count;
      }
    }
    return count;
  }

  // Returns the characteristic of the sheet as if nothing had been cut.
  [[nodiscard]] std::int64_t solid_characteristic() const {
    std::set<mesh::PointId> points;
    std::int64_t twice_edges = 0;
    std::int64_t num_triangles = 0;
    for (const TriangleRecord& r : data_.triangles) {
      if (r.region < 0) continue;
      ++num_triangles;
      points.insert(r.points.begin(), r.points.end());
      for (std::size_t k = 0; k < 3; ++k) twice_edges += (r.locks[k] & mesh::kLockBorder) != 0 ? 2 : 1;
    }
    return static_cast<std::int64_t>(points.size()) - twice_edges / 2 + num_triangles;
  }

  const mesh::MeshData& data_;
  // Locks, then the edges between regions of the sheet, where a path gets points but none that count, then the path.
  std::vector<Segment> segments_;
  std::size_t num_locks_ = 0;
  std::size_t first_path_ = 0;
  double search_;     // lattice units; things farther from each other are not compared
  double clearance_;  // lattice units
  std::size_t num_nodes_ = 0;
  std::map<LatticePoint, std::size_t> node_at_;
};

}  // namespace

Outcome exact_outcome(const mesh::TriangleMesh& sheet, const std::vector<cut::Stroke>& strokes, double& clearance) {
  Arrangement arrangement(sheet, strokes, clearance);
  const Outcome outcome = arrangement.run();
  clearance = arrangement.clearance();
  return outcome;
}

}  // namespace kerf::oracle
