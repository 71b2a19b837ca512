#include "server/core/mesh/build/outline_border.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "server/base/interruption.h"
#include "server/core/mesh/build/contour_division.h"
#include "server/core/mesh/lattice_geometry.h"

namespace kerf::mesh {
namespace {

using Eigen::Vector2d;

constexpr double kMinSize = 1e-9;  // m; least size of an outline
constexpr int kBisections = 50;    // enough to reduce an interval of stations to rounding

Vector2d as_vector(const LatticePoint& p) {
  return difference({}, p);
}

std::string place_of(const Lattice& lattice, const LatticePoint& at) {
  const Vector2d position = lattice.position(at);
  char text[64];
  std::snprintf(text, sizeof text, "(%.6g, %.6g)", position.x(), position.y());
  return text;
}

// Returns true if the closed segments have a point in common.
bool meet(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  const int ac = orient2d(a, b, c), ad = orient2d(a, b, d), ca = orient2d(c, d, a), cb = orient2d(c, d, b);
  if (ac != 0 || ad != 0 || ca != 0 || cb != 0) return ac * ad <= 0 && ca * cb <= 0;
  // All four points lie on one line: compares the intervals.
  return std::max(std::min(a, b), std::min(c, d)) <= std::min(std::max(a, b), std::max(c, d));
}

// Returns the crossing of two segments that meet, or an end of one on the other.
LatticePoint common_point(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  if (segments_cross(a, b, c, d)) return rounded_crossing(a, b, c, d);
  for (const LatticePoint& end : {c, d}) {
    if (meet(a, b, end, end)) return end;
  }
  return meet(c, d, a, a) ? a : b;
}

// Returns true if `at` lies inside the polygon or on it (even-odd rule).
bool surrounds(const std::vector<LatticePoint>& polygon, const LatticePoint& at) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const LatticePoint& a = polygon[i];
    const LatticePoint& b = polygon[(i + 1) % polygon.size()];
    if (a == b) continue;
    if (meet(a, b, at, at)) return true;
    if ((a.y > at.y) != (b.y > at.y) && (orient2d(a, b, at) > 0) == (b.y > a.y)) inside = !inside;
  }
  return inside;
}

// A contour rounded to the lattice.
struct Quantised {
  std::vector<Vector2d> points;
  std::vector<std::size_t> corners;
};

Quantised quantise(const OutlineContour& contour, const Lattice& lattice) {
  Quantised result;
  std::vector<LatticePoint> kept;
  auto corner = contour.corners.begin();
  for (std::size_t i = 0; i < contour.points.size(); ++i) {
    const LatticePoint at = lattice.nearest(contour.points[i]);
    const bool is_corner = corner != contour.corners.end() && *corner == i;
    if (is_corner) ++corner;
    if (kept.empty() || kept.back() != at) kept.push_back(at);
    if (is_corner && (result.corners.empty() || result.corners.back() != kept.size() - 1)) {
      result.corners.push_back(kept.size() - 1);
    }
  }
  while (kept.size() > 1 && kept.back() == kept.front()) {
    if (!result.corners.empty() && result.corners.back() == kept.size() - 1) {
      result.corners.pop_back();
      if (result.corners.empty() || result.corners.front() != 0) result.corners.insert(result.corners.begin(), 0);
    }
    kept.pop_back();
  }
  for (const LatticePoint& at : kept) result.points.push_back(lattice.position(at));
  return result;
}

}  // namespace

OutlineBorder::OutlineBorder(std::vector<Contour> contours, std::vector<std::string> fields, const Lattice& lattice)
    : contours_(std::move(contours)), fields_(std::move(fields)), lattice_(lattice), tree_({}) {
  for (std::size_t c = 0; c < contours_.size(); ++c) {
    const Contour& contour = contours_[c];
    for (std::size_t i = 0; i < contour.num_points(); ++i) {
      chords_.push_back({static_cast<std::int32_t>(c), static_cast<std::int32_t>(i), lattice_.nearest(contour.point(i)),
                         lattice_.nearest(contour.point((i + 1) % contour.num_points()))});
      if (c == 0) bounds_.extend(contour.point(i));
    }
  }
  tree_ = BoxTree(chord_boxes());
}

double OutlineBorder::area() const {
  std::vector<double> doubled(contours_.size());
  for (const Chord& chord : chords_) {
    const Vector2d from = as_vector(chord.from), to = as_vector(chord.to);
    doubled[chord.contour] += from.x() * to.y() - from.y() * to.x();
  }
  double area = std::abs(doubled[0]);
  for (std::size_t c = 1; c < doubled.size(); ++c) area -= std::abs(doubled[c]);
  return 0.5 * area * lattice_.spacing * lattice_.spacing;
}

std::vector<Eigen::AlignedBox2d> OutlineBorder::chord_boxes() const {
  std::vector<Eigen::AlignedBox2d> boxes;
  boxes.reserve(chords_.size());
  for (const Chord& chord : chords_) {
    boxes.emplace_back(as_vector(chord.from).cwiseMin(as_vector(chord.to)),
                       as_vector(chord.from).cwiseMax(as_vector(chord.to)));
  }
  return boxes;
}

Result<OutlineBorder> OutlineBorder::make(const std::vector<OutlineContour>& contours) {
  Eigen::AlignedBox2d box;
  for (const OutlineContour& contour : contours) {
    for (const Vector2d& point : contour.points) box.extend(point);
  }
  if (box.isEmpty() || box.sizes().maxCoeff() < kMinSize) {
    return invalid_argument("OUTLINE_DEGENERATE", "the outline is smaller than 1e-9 m",
                            contours.empty() ? "" : contours.front().field);
  }
  const Lattice lattice = Lattice::for_bounds(box);
  std::vector<Contour> kept;
  std::vector<std::string> fields;
  for (const OutlineContour& contour : contours) {
    Quantised quantised = quantise(contour, lattice);
    if (quantised.points.size() < 3) {
      return invalid_argument("OUTLINE_DEGENERATE",
                              contour.field + " has fewer than three different points, so it encloses nothing",
                              contour.field);
    }
    kept.emplace_back(std::move(quantised.points), quantised.corners);
    fields.push_back(contour.field);
  }
  OutlineBorder border(std::move(kept), std::move(fields), lattice);
  KERF_TRY(border.check_crossings());
  return border;
}

bool OutlineBorder::are_neighbours(const Chord& a, const Chord& b) const {
  if (a.contour != b.contour) return false;
  const auto size = static_cast<std::int32_t>(contours_[a.contour].num_points());
  return (a.index + 1) % size == b.index || (b.index + 1) % size == a.index;
}

// Returns true if two different chords have more in common than the end that neighbours share.
bool OutlineBorder::conflict(const Chord& a, const Chord& b) const {
  if (!are_neighbours(a, b)) return meet(a.from, a.to, b.from, b.to);
  const bool is_in_order = a.to == b.from;
  const LatticePoint& joint = is_in_order ? a.to : a.from;
  const LatticePoint& p = is_in_order ? a.from : a.to;
  const LatticePoint& q = is_in_order ? b.to : b.from;
  return orient2d(p, joint, q) == 0 && dot(joint, p, joint, q) >= 0;
}

Status OutlineBorder::check_crossings() const {
  const std::vector<Eigen::AlignedBox2d> boxes = chord_boxes();
  for (std::size_t i = 0; i < chords_.size(); ++i) {
    interruption_point();
    const Chord& a = chords_[i];
    std::size_t met = i;
    if (tree_.visit_meeting(boxes[i], [&](std::int32_t other) {
          const auto j = static_cast<std::size_t>(other);
          if (j > i && conflict(a, chords_[j])) met = j;
          return met == i;
        })) {
      continue;
    }
    const Chord& b = chords_[met];
    const std::string near = " at " + place_of(lattice_, common_point(a.from, a.to, b.from, b.to)) + " m";
    const std::string what = a.contour == b.contour ? " crosses or touches itself" + near
                                                    : " crosses or touches " + fields_[a.contour] + near +
                                                          "; leave some material between them";
    return invalid_argument("OUTLINE_CROSSES", fields_[b.contour] + what, fields_[b.contour]);
  }
  return Nothing{};
}

LatticePoint OutlineBorder::at(std::int32_t contour, double station) const {
  return lattice_.nearest(contours_[contour].at(station));
}

// Returns true if one straight edge may replace this part of a contour. No other contour may lie between the edge and
// the part, and the part may not turn too much.
bool OutlineBorder::can_be_one_edge(const Span& span) const {
  const Contour& contour = contours_[span.contour];
  const std::size_t first = contour.chord_at(span.from);
  const std::size_t last =
      contour.station(contour.chord_at(span.to)) == span.to ? contour.chord_at(span.to) - 1 : contour.chord_at(span.to);
  if (first == last) return true;
  std::vector<LatticePoint> region{at(span.contour, span.from)};
  double turn = 0.0;
  for (std::size_t i = first + 1; i <= last; ++i) {
    turn += contour.turn(i);
    // Even divisions keep kMaxTurnOfEdge on average only, so single edges may turn a little more.
    if (turn > 1.5 * kMaxTurnOfEdge) return false;
    region.push_back(lattice_.nearest(contour.point(i)));
  }
  region.push_back(at(span.contour, span.to));
  Eigen::AlignedBox2d box;
  for (const LatticePoint& p : region) box.extend(as_vector(p));
  const LatticePoint& start = region.front();
  const LatticePoint& end = region.back();
  return tree_.visit_meeting(box, [&](std::int32_t index) {
    const Chord& chord = chords_[static_cast<std::size_t>(index)];
    const auto i = static_cast<std::size_t>(chord.index);
    if (chord.contour == span.contour && i >= first && i <= last) return true;
    const bool from_joins = chord.from == start || chord.from == end;
    const bool to_joins = chord.to == start || chord.to == end;
    if (from_joins && to_joins) return false;
    if (from_joins || to_joins) return !surrounds(region, from_joins ? chord.to : chord.from);
    return !meet(start, end, chord.from, chord.to) && !surrounds(region, chord.from);
  });
}

// Appends the vertex at the start of a part of a contour. Halves the part, and appends vertices inside it, until edges
// can replace all parts.
bool OutlineBorder::append(const Span& span, std::int64_t max_vertices) {
  const double middle = 0.5 * (span.from + span.to);
  if (can_be_one_edge(span) || middle <= span.from || middle >= span.to) {
    vertices_.push_back({span.contour, span.from, at(span.contour, span.from)});
    return static_cast<std::int64_t>(vertices_.size()) <= max_vertices;
  }
  return append({span.contour, span.from, middle}, max_vertices) &&
         append({span.contour, middle, span.to}, max_vertices);
}

bool OutlineBorder::divide(const SizeField& sizes, std::int64_t max_vertices) {
  vertices_.clear();
  for (std::size_t c = 0; c < contours_.size(); ++c) {
    const Contour& contour = contours_[c];
    std::vector<double> stations{0.0};
    for (std::size_t i = 0; i < contour.num_points();) {
      const std::size_t start = i;
      for (++i; i < contour.num_points() && !contour.is_corner(i);) ++i;
      const double least = start == 0 && i == contour.num_points() ? 3.0 : 1.0;
      const double room = static_cast<double>(max_vertices) - static_cast<double>(vertices_.size() + stations.size());
      if (!divide_stretch(contour, {contour.station(start), contour.station(i)}, sizes, {least, room}, stations))
        return false;
      stations.push_back(contour.station(i));
    }
    for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
      if (stations[i] >= stations[i + 1]) continue;
      if (!append({static_cast<std::int32_t>(c), stations[i], stations[i + 1]}, max_vertices)) return false;
    }
  }
  link();
  return true;
}

bool OutlineBorder::renew(std::int64_t max_vertices) {
  std::vector<Vertex> known = std::move(vertices_);
  known.insert(known.end(), missed_.begin(), missed_.end());
  missed_.clear();
  missed_edges_.clear();
  vertices_.clear();
  std::sort(known.begin(), known.end(), [](const Vertex& a, const Vertex& b) {
    return std::pair(a.contour, a.station) < std::pair(b.contour, b.station);
  });
  for (std::size_t i = 0; i < known.size(); ++i) {
    const bool is_last = i + 1 == known.size() || known[i + 1].contour != known[i].contour;
    const double end = is_last ? contours_[known[i].contour].length() : known[i + 1].station;
    if (known[i].station < end && !append({known[i].contour, known[i].station, end}, max_vertices)) return false;
  }
  link();
  return true;
}

void OutlineBorder::link() {
  next_.assign(vertices_.size(), 0);
  for (std::size_t first = 0, end = 0; first < vertices_.size(); first = end) {
    for (end = first; end < vertices_.size() && vertices_[end].contour == vertices_[first].contour; ++end) {
      next_[end] = static_cast<std::int32_t>(end + 1);
    }
    next_[end - 1] = static_cast<std::int32_t>(first);
  }
}

void OutlineBorder::follow(const Lattice& mesh_lattice) {
  mesh_lattice_ = mesh_lattice;
  vertex_of_.resize(vertices_.size());
  for (std::size_t v = 0; v < vertices_.size(); ++v) vertex_of_[v] = static_cast<std::int32_t>(v);
}

// Returns the station of `to`, which follows `from` on the contour. Adds the length of the contour if station 0 lies in
// between.
double OutlineBorder::station_after(const Vertex& from, const Vertex& to) const {
  return to.station > from.station ? to.station : to.station + contours_[from.contour].length();
}

LatticePoint OutlineBorder::between(PointId p, PointId q, double distance) {
  const std::int32_t v = vertex_of_[p], w = vertex_of_[q];
  const Vertex& from = vertices_[v];
  const Contour& contour = contours_[from.contour];
  const bool is_forward = next_[v] == w;
  const double from_station = is_forward ? from.station : station_after(vertices_[w], from);
  double low = from_station;
  double high = is_forward ? station_after(from, vertices_[w]) : vertices_[w].station;
  const auto wrapped = [&](double station) {
    return station >= contour.length() ? station - contour.length() : station;
  };
  const Vector2d start = contour.at(from.station);
  const double reach = distance * mesh_lattice_.spacing;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    ((contour.at(wrapped(middle)) - start).norm() < reach ? low : high) = middle;
  }
  proposed_ = wrapped(0.5 * (low + high));
  return mesh_lattice_.nearest(contour.at(proposed_));
}

void OutlineBorder::miss(PointId p, PointId q) {
  if (!missed_edges_.insert({std::min(p, q), std::max(p, q)}).second) return;
  const std::int32_t contour = vertices_[vertex_of_[p]].contour;
  missed_.push_back({contour, proposed_, at(contour, proposed_)});
}

void OutlineBorder::add(PointId p, PointId q, PointId added) {
  const std::int32_t v = vertex_of_[p], w = vertex_of_[q];
  const std::int32_t contour = vertices_[v].contour;
  const auto vertex = static_cast<std::int32_t>(vertices_.size());
  vertices_.push_back({contour, proposed_, at(contour, proposed_)});
  const std::int32_t before = next_[v] == w ? v : w;
  next_.push_back(next_[before]);
  next_[before] = vertex;
  vertex_of_.resize(static_cast<std::size_t>(added) + 1, kNone);
  vertex_of_[added] = vertex;
}

}  // namespace kerf::mesh
