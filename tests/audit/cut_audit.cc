#include "tests/audit/cut_audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "tests/audit/box_grid.h"
#include "tests/audit/path_audit.h"
#include "tests/audit/strip_audit.h"

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

__extension__ using Wide = __int128;

// A point this near to an older lip was put on it.  lattice units
constexpr double kOnLip = 12.0;

std::size_t index(std::int32_t id) {
  return static_cast<std::size_t>(id);
}

// The turn from a to b around the origin.
Wide turn(const LatticePoint& a, const LatticePoint& b) {
  return Wide{a.x} * b.y - Wide{a.y} * b.x;
}
LatticePoint minus(const LatticePoint& a, const LatticePoint& b) {
  return {a.x - b.x, a.y - b.y};
}

// Three times the centre of a triangle.
LatticePoint tripled_centre(const MeshData& data, const TriangleRecord& r) {
  LatticePoint sum;
  for (const mesh::PointId p : r.points) {
    sum.x += data.points[index(p)].at.x;
    sum.y += data.points[index(p)].at.y;
  }
  return sum;
}

class CutAudit {
 public:
  CutAudit(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
           const cut::CutOutcome& outcome)
      : before_mesh_(before),
        after_mesh_(after),
        old_(before.data()),
        now_(after.data()),
        plan_(plan),
        outcome_(outcome),
        grid_({}) {}

  Finding run() {
    if (Finding found = find_flaw(after_mesh_, &census_)) return found;
    index_old_mesh();
    for (const auto check : {&CutAudit::check_characteristic, &CutAudit::check_areas, &CutAudit::check_parents,
                             &CutAudit::check_what_stays, &CutAudit::check_sources, &CutAudit::check_lip_sources,
                             &CutAudit::check_edit, &CutAudit::check_pieces, &CutAudit::check_report}) {
      if (Finding found = (this->*check)()) return found;
    }
    if (takes_material()) {
      if (Finding found = find_strip_flaw(before_mesh_, after_mesh_, plan_, outcome_)) return found;
    }
    return find_path_flaw(before_mesh_, after_mesh_, plan_, outcome_.report);
  }

 private:
  [[nodiscard]] bool takes_material() const { return plan_.options.width_m.has_value(); }
  static bool is_solid(const TriangleRecord& r) { return r.region >= 0; }
  static std::string text(const char* what, VertexId v) { return std::string(what) + ": vertex " + std::to_string(v); }

  void index_old_mesh() {
    std::vector<Box> boxes;
    corners_at_.resize(old_.points.size());
    for (std::size_t t = 0; t < old_.triangles.size(); ++t) {
      const TriangleRecord& r = old_.triangles[t];
      if (!is_solid(r)) continue;
      Box box;
      for (std::size_t k = 0; k < 3; ++k) {
        box.extend(at(r.points[k]));
        corners_at_[index(r.points[k])].push_back(t);
      }
      boxes.push_back(box);
      solid_.push_back(t);
      for (std::size_t k = 0; k < 3; ++k) {
        const VertexId from = r.vertices[(k + 1) % 3];
        const VertexId to = r.vertices[(k + 2) % 3];
        old_edges_.push_back({{from, to}, (r.locks[k] & (mesh::kLockCut | mesh::kLockBorder)) != 0});
        std::array<VertexId, 3> sorted = r.vertices;
        std::sort(sorted.begin(), sorted.end());
        old_corners_.push_back(sorted);
      }
    }
    std::sort(old_edges_.begin(), old_edges_.end());
    std::sort(old_corners_.begin(), old_corners_.end());
    grid_ = BoxGrid(std::move(boxes));
    first_slot_of_.resize(now_.vertices.size());
    for (std::size_t t = now_.triangles.size(); t-- > 0;) {
      if (!is_solid(now_.triangles[t])) continue;
      for (const VertexId v : now_.triangles[t].vertices) first_slot_of_[index(v)] = t;
    }
  }
  [[nodiscard]] Vector2d at(mesh::PointId p) const {
    return {static_cast<double>(old_.points[index(p)].at.x), static_cast<double>(old_.points[index(p)].at.y)};
  }

  Finding check_characteristic() {
    Census before;
    if (Finding found = find_flaw(before_mesh_, &before)) return "before the cut: " + *found;
    if (takes_material()) return std::nullopt;
    if (census_.welded_characteristic() != before.welded_characteristic()) {
      return "the sheet, closed again along its cuts, has another Euler characteristic";
    }
    if (census_.pieces < before.pieces) return "pieces have grown together";
    if (census_.extra_fans == before.extra_fans && census_.pieces == before.pieces) return "the cut opened nothing";
    return std::nullopt;
  }

  // Leaves the area of a removed strip to find_strip_flaw.
  Finding check_areas() {
    if (takes_material()) return std::nullopt;
    std::map<std::int32_t, Wide> area;  // twice the change, by region
    std::map<std::int32_t, Wide> total;
    const auto add = [&](const MeshData& data, int sign) {
      for (const TriangleRecord& r : data.triangles) {
        if (!is_solid(r)) continue;
        const LatticePoint& a = data.points[index(r.points[0])].at;
        const Wide doubled =
            turn(minus(data.points[index(r.points[1])].at, a), minus(data.points[index(r.points[2])].at, a));
        area[r.region] += sign * doubled;
        total[r.region] += doubled;
      }
    };
    add(old_, -1);
    add(now_, 1);
    // Facets of a curved sheet may be as small as triangles, whose edges, where they are split, are rounded.
    Wide whole = 0;
    for (const auto& [region, doubled] : total) whole += doubled;
    for (const auto& [region, change] : area) {
      const double allowed = 0.5e-12 * static_cast<double>(now_.surface ? whole : total[region]);
      if (std::abs(static_cast<double>(change)) > allowed) {
        return "region " + std::to_string(region) + " has lost or gained area";
      }
    }
    return std::nullopt;
  }

  // The old solid triangle that holds three times `place`, or the largest index.
  std::size_t old_triangle_at(const LatticePoint& tripled) {
    const Vector2d place(static_cast<double>(tripled.x) / 3.0, static_cast<double>(tripled.y) / 3.0);
    std::size_t found = old_.triangles.size();
    grid_.for_touching(Box(place.array() - 2.0, place.array() + 2.0), [&](std::size_t i) {
      const TriangleRecord& r = old_.triangles[solid_[i]];
      for (std::size_t k = 0; k < 3; ++k) {
        const LatticePoint& a = old_.points[index(r.points[k])].at;
        const LatticePoint& b = old_.points[index(r.points[(k + 1) % 3])].at;
        if (turn(minus(b, a), {tripled.x - 3 * a.x, tripled.y - 3 * a.y}) < 0) return;
      }
      found = solid_[i];
    });
    return found;
  }

  Finding check_parents() {
    for (const mesh::TriangleId t : outcome_.edit.rewritten_triangles) {
      if (t < 0 || index(t) >= now_.triangles.size()) return "a rewritten slot that does not exist";
      const TriangleRecord& r = now_.triangles[index(t)];
      if (!is_solid(r)) continue;
      const std::size_t parent = old_triangle_at(tripled_centre(now_, r));
      if (parent == old_.triangles.size()) return "slot " + std::to_string(t) + " lies where no material was";
      if (old_.triangles[parent].region != r.region) return "slot " + std::to_string(t) + " has the wrong region";
    }
    return std::nullopt;
  }

  Finding check_what_stays() {
    std::vector<bool> moved(old_.points.size());
    for (const VertexSource& source : outcome_.edit.moved_vertices) {
      const VertexId v = source.vertex;
      if (v < 0 || index(v) >= old_.vertices.size()) return text("moved, but not there before", v);
      const auto p = index(old_.vertices[index(v)].point);
      if (old_.points[p].at == now_.points[p].at) return text("said to have moved", v);
      moved[p] = true;
    }
    for (std::size_t p = 0; p < old_.points.size(); ++p) {
      if (!moved[p] && old_.points[p].at != now_.points[p].at) return "point " + std::to_string(p) + " has moved";
    }
    for (std::size_t v = 0; v < old_.vertices.size(); ++v) {
      if (old_.vertices[v].point != now_.vertices[v].point) return text("at another point", static_cast<VertexId>(v));
    }
    for (const VertexId v : plan_.fixed_vertices) {
      if (moved[index(old_.vertices[index(v)].point)]) return text("fixed and yet moved", v);
    }
    for (const TriangleRecord& r : old_.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (r.locks[k] == 0) continue;
        if (moved[index(r.points[(k + 1) % 3])] || moved[index(r.points[(k + 2) % 3])]) return "a lip has moved";
      }
    }
    return std::nullopt;
  }

  // Old vertices that share a triangle, weights of a mean, and the rest position they give.
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
      sum += w * at(old_.vertices[index(v)].point);
      if (w > 0.0 && std::find(used.begin(), used.begin() + num_used, v) == used.begin() + num_used) {
        used[num_used++] = v;
      }
    }
    if (!(std::abs(weight - 1.0) <= 1e-14)) return text("weights that do not sum to 1", source.vertex);
    const LatticePoint& is = now_.points[index(now_.vertices[index(source.vertex)].point)].at;
    if ((sum - Vector2d(static_cast<double>(is.x), static_cast<double>(is.y))).norm() > 1e-12 * 0x1.0p51) {
      return text("sources that give another rest position", source.vertex);
    }
    if (num_used == 3) {
      std::sort(used.begin(), used.end());
      if (!std::binary_search(old_corners_.begin(), old_corners_.end(), used)) {
        return text("sources that share no triangle", source.vertex);
      }
    }
    if (num_used == 2 && edge_kind(used[0], used[1]) == EdgeKind::kAbsent &&
        edge_kind(used[1], used[0]) == EdgeKind::kAbsent) {
      return text("two sources that share no edge", source.vertex);
    }
    return std::nullopt;
  }

  enum class EdgeKind { kAbsent, kInner, kOpen };
  // Returns the kind of the side of an old solid triangle that runs from a to b.
  [[nodiscard]] EdgeKind edge_kind(VertexId a, VertexId b) const {
    const auto found = std::lower_bound(old_edges_.begin(), old_edges_.end(), OldEdge{{a, b}, false});
    if (found == old_edges_.end() || found->first != std::pair{a, b}) return EdgeKind::kAbsent;
    return found->second ? EdgeKind::kOpen : EdgeKind::kInner;
  }

  Finding check_sources() {
    const auto& added = outcome_.edit.added_vertices;
    if (added.size() != now_.vertices.size() - old_.vertices.size()) return "added_vertices has another length";
    for (std::size_t i = 0; i < added.size(); ++i) {
      if (index(added[i].vertex) != old_.vertices.size() + i) return "added_vertices out of order";
      if (Finding found = check_source(added[i])) return found;
    }
    for (const VertexSource& source : outcome_.edit.moved_vertices) {
      if (Finding found = check_source(source)) return found;
    }
    return std::nullopt;
  }

  // Each vertex inherits from its own side of every old lip.
  Finding check_lip_sources() {
    std::map<mesh::PointId, const VertexSource*> first_at;
    for (std::size_t v = 0; v < now_.vertices.size(); ++v) {
      if (now_.vertices[v].triangle == kNone) continue;
      const mesh::PointId p = now_.vertices[v].point;
      const bool is_new = v >= old_.vertices.size();
      const VertexSource* source = is_new ? &outcome_.edit.added_vertices[v - old_.vertices.size()] : nullptr;
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

  // At an old point: copied from the old vertex in whose sector it lies.
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
    for (const std::size_t t : corners_at_[index(p)]) {
      const TriangleRecord& r = old_.triangles[t];
      const auto k = static_cast<std::size_t>(std::find(r.points.begin(), r.points.end(), p) - r.points.begin());
      const LatticePoint right = minus(old_.points[index(r.points[(k + 1) % 3])].at, here);
      const LatticePoint left = minus(old_.points[index(r.points[(k + 2) % 3])].at, here);
      if (turn(right, direction) < 0 || turn(direction, left) < 0) continue;
      if (r.vertices[k] == origin) return std::nullopt;
    }
    return text("in a sector that belonged to another vertex", static_cast<VertexId>(v));
  }

  // True if the point was put on an existing lip or border.
  bool lies_on_lip(const VertexSource& source) {
    const LatticePoint& place = now_.points[index(now_.vertices[index(source.vertex)].point)].at;
    const Vector2d here(static_cast<double>(place.x), static_cast<double>(place.y));
    bool found = false;
    grid_.for_touching(Box(here.array() - kOnLip, here.array() + kOnLip), [&](std::size_t i) {
      const TriangleRecord& r = old_.triangles[solid_[i]];
      for (std::size_t k = 0; k < 3; ++k) {
        if (r.locks[k] == 0) continue;
        const Vector2d a = at(r.points[(k + 1) % 3]);
        const Vector2d along = at(r.points[(k + 2) % 3]) - a;
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
    if (edge_kind(a, b) != EdgeKind::kOpen) std::swap(a, b);
    if (edge_kind(a, b) != EdgeKind::kOpen) return text("on a lip, but not made of its ends", source.vertex);
    const auto is_left = [&](VertexId from, VertexId to) {
      const LatticePoint& start = old_.points[index(old_.vertices[index(from)].point)].at;
      const LatticePoint& end = old_.points[index(old_.vertices[index(to)].point)].at;
      const LatticePoint tripled = tripled_centre(now_, now_.triangles[first_slot_of_[v]]);
      return turn(minus(end, start), {tripled.x - 3 * start.x, tripled.y - 3 * start.y}) > 0;
    };
    // Both sides of a lip between the same two vertices only where both are tips.
    if (is_left(a, b) || (edge_kind(b, a) == EdgeKind::kOpen && is_left(b, a))) return std::nullopt;
    return text("made of the other side's vertices", source.vertex);
  }

  // Without what lies across lips and border, which the opened mesh does not see.
  static TriangleRecord opened(TriangleRecord r) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (r.locks[k] == 0) continue;
      r.neighbours[k] = kNone;
      r.locks[k] = mesh::kLockBorder;  // a lip becomes border where the material across goes
    }
    return r;
  }

  // A copy of the old opened mesh in which only what the edit lists is replaced must be the new one.
  Finding check_edit() {
    const auto& rewritten = outcome_.edit.rewritten_triangles;
    if (!std::is_sorted(rewritten.begin(), rewritten.end()) ||
        std::adjacent_find(rewritten.begin(), rewritten.end()) != rewritten.end()) {
      return "rewritten_triangles is not sorted and unique";
    }
    std::vector<bool> listed(now_.triangles.size());
    for (const mesh::TriangleId t : rewritten) listed[index(t)] = true;
    for (std::size_t t = 0; t < now_.triangles.size(); ++t) {
      if (listed[t]) continue;
      const std::string slot = "slot " + std::to_string(t);
      if (t >= old_.triangles.size()) return slot + " is new but not listed";
      TriangleRecord expected = opened(old_.triangles[t]);
      const TriangleRecord is = opened(now_.triangles[t]);
      if (is_solid(is) || is_solid(expected)) {
        expected.piece = is.piece;
        if (!(expected == is)) return slot + " changed but is not listed";
        for (const mesh::PointId p : is.points) {
          if (old_.points[index(p)].at != now_.points[index(p)].at) return slot + " changed shape but is not listed";
        }
      }
    }
    return std::nullopt;
  }

  // The number that a piece had until others, all of which was removed, were given up.
  [[nodiscard]] std::int32_t before_renumbering(std::int32_t piece) const {
    const auto& vanished = outcome_.edit.removed_pieces;
    std::int32_t count = now_.num_pieces;
    for (auto gone = vanished.rbegin(); gone != vanished.rend(); ++gone, ++count) {
      if (piece == *gone) piece = count;
    }
    return piece;
  }

  Finding check_pieces() {
    std::vector<std::int32_t> parent(index(now_.num_pieces) + outcome_.edit.removed_pieces.size(), kNone);
    for (std::size_t t = 0; t < old_.triangles.size(); ++t) {
      const std::int32_t was = old_.triangles[t].piece;
      std::int32_t is = now_.triangles[t].piece;
      if (was == kNone) continue;
      if (std::binary_search(outcome_.edit.rewritten_triangles.begin(), outcome_.edit.rewritten_triangles.end(),
                             static_cast<mesh::TriangleId>(t))) {
        continue;
      }
      is = before_renumbering(is);
      if (is < old_.num_pieces && is != was) return "slot " + std::to_string(t) + " went over to another old piece";
      if (parent[index(is)] == kNone) parent[index(is)] = was;
      if (parent[index(is)] != was) return "piece " + std::to_string(is) + " comes from two";
    }
    return std::nullopt;
  }

  Finding check_report() {
    const cut::CutReport& report = outcome_.report;
    if (report.deviation_m > largest_tolerance(before_mesh_, plan_) || report.deviation_of_tolerance > 1.0) {
      return "the deviation is beyond the tolerance";
    }
    const auto expect = [](const char* name, std::int64_t said, std::int64_t is) -> Finding {
      if (said == is) return std::nullopt;
      return std::string(name) + " is said to be " + std::to_string(said) + " and is " + std::to_string(is);
    };
    const auto size = [](const auto& list) { return static_cast<std::int64_t>(list.size()); };
    for (const Finding& found :
         {expect("pieces", report.pieces, census_.pieces),
          expect("new_vertices", report.new_vertices, size(now_.vertices) - size(old_.vertices)),
          expect("new_triangles", report.new_triangles, solid_in_new_slots()),
          expect("rewritten_triangles", report.rewritten_triangles, size(outcome_.edit.rewritten_triangles)),
          expect("moved_vertices", report.moved_vertices, size(outcome_.edit.moved_vertices))}) {
      if (found) return found;
    }
    return check_shapes();
  }

  [[nodiscard]] std::int64_t solid_in_new_slots() const {
    return std::count_if(now_.triangles.begin() + static_cast<std::ptrdiff_t>(old_.triangles.size()),
                         now_.triangles.end(), is_solid);
  }

  // Returns the positions of a triangle's corners, in a fixed order.
  static std::array<LatticePoint, 3> places_of(const MeshData& data, const TriangleRecord& r) {
    std::array<LatticePoint, 3> places{};
    for (std::size_t k = 0; k < 3; ++k) places[k] = data.points[index(r.points[k])].at;
    std::sort(places.begin(), places.end());
    return places;
  }

  // Lattice units, in the rest shape: where that is curved, on the facet of r.
  [[nodiscard]] double length_of(const TriangleRecord& r, const LatticePoint& p, const LatticePoint& q) const {
    const Eigen::Vector2d flat(static_cast<double>(p.x - q.x), static_cast<double>(p.y - q.y));
    return now_.surface ? (now_.surface->facets[index(r.region)].axes * flat).norm() : std::hypot(flat.x(), flat.y());
  }

  [[nodiscard]] double area_ratio_of(const TriangleRecord& r) const {
    if (!now_.surface) return 1.0;
    const Eigen::Matrix<double, 3, 2>& axes = now_.surface->facets[index(r.region)].axes;
    return std::sqrt((axes.transpose() * axes).determinant());
  }

  // Checks the shapes of new triangles. Angles come from side lengths, heights from the area.
  Finding check_shapes() {
    const cut::CutQuality& quality = outcome_.report.quality;
    std::vector<std::array<LatticePoint, 3>> old_places;
    for (const std::size_t t : solid_) old_places.push_back(places_of(old_, old_.triangles[t]));
    std::sort(old_places.begin(), old_places.end());
    double least_angle = 180.0, most_aspect = 0.0, least_height = std::numeric_limits<double>::infinity();
    for (const mesh::TriangleId t : outcome_.edit.rewritten_triangles) {
      const TriangleRecord& r = now_.triangles[index(t)];
      if (!is_solid(r)) continue;
      // A new point may lie where relaxing took an old one away.
      const bool has_new_point = std::any_of(r.points.begin(), r.points.end(),
                                             [&](mesh::PointId p) { return index(p) >= old_.points.size(); });
      if (!has_new_point && std::binary_search(old_places.begin(), old_places.end(), places_of(now_, r))) continue;
      const LatticePoint& a = now_.points[index(r.points[0])].at;
      const LatticePoint& b = now_.points[index(r.points[1])].at;
      const LatticePoint& c = now_.points[index(r.points[2])].at;
      std::array<double, 3> side{length_of(r, a, b), length_of(r, b, c), length_of(r, c, a)};
      std::sort(side.begin(), side.end());
      const double doubled = area_ratio_of(r) * static_cast<double>(turn(minus(b, a), minus(c, a)));
      const double angle = std::asin(std::min(1.0, doubled / (side[1] * side[2]))) * 180.0 / std::numbers::pi;
      const double height = doubled / side[2];
      least_angle = std::min(least_angle, angle);
      least_height = std::min(least_height, height * now_.lattice.spacing);
      most_aspect = std::max(most_aspect, side[2] / height);
    }
    if (least_angle == 180.0) return std::nullopt;  // a cut along edges that are there makes none
    if (std::abs(quality.min_angle_deg - least_angle) > 1e-5) return "min_angle_deg is not that of the triangles";
    if (std::abs(quality.min_height_m - least_height) > 1e-9 * least_height) return "min_height_m is wrong";
    if (std::abs(quality.max_aspect - most_aspect) > 1e-9 * most_aspect) return "max_aspect is wrong";
    return std::nullopt;
  }

  using OldEdge = std::pair<std::pair<VertexId, VertexId>, bool>;  // from, to; open

  const mesh::TriangleMesh& before_mesh_;
  const mesh::TriangleMesh& after_mesh_;
  const MeshData& old_;
  const MeshData& now_;
  const cut::CutPlan& plan_;
  const cut::CutOutcome& outcome_;
  Census census_;
  std::vector<std::size_t> solid_;                    // slots of the old mesh
  BoxGrid grid_;                                      // over those
  std::vector<std::vector<std::size_t>> corners_at_;  // old point -> old solid slots
  std::vector<OldEdge> old_edges_;                    // sorted
  std::vector<std::array<VertexId, 3>> old_corners_;  // sorted, each sorted
  std::vector<std::size_t> first_slot_of_;            // vertex now -> its lowest slot
};

}  // namespace

Finding find_cut_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                      const cut::CutOutcome& outcome) {
  return CutAudit(before, after, plan, outcome).run();
}

Finding find_difference(const mesh::TriangleMesh& a, const mesh::TriangleMesh& b) {
  const MeshData& x = a.data();
  const MeshData& y = b.data();
  if (!(x.lattice == y.lattice)) return "the lattices differ";
  if (x.bounds.min() != y.bounds.min() || x.bounds.max() != y.bounds.max()) return "the bounds differ";
  if (!(x.lengths == y.lengths)) return "the edge lengths differ";
  if (x.points != y.points) return "the points differ";
  if (x.vertices != y.vertices) return "the vertices differ";
  if (x.triangles != y.triangles) return "the triangles differ";
  if (x.num_solid_triangles != y.num_solid_triangles) return "the numbers of triangles differ";
  if (x.num_pieces != y.num_pieces) return "the numbers of pieces differ";
  if (!a.has_surface_of(b)) return "the rest surfaces differ";
  return std::nullopt;
}

}  // namespace kerf::audit
