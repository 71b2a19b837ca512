#include "server/core/mesh/build/face_repair.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "server/base/interruption.h"
#include "server/core/mesh/build/coincidence.h"
#include "server/core/mesh/ids.h"

namespace kerf::mesh {
namespace {

using Polygon = FacePolygons::Polygon;

constexpr std::size_t kMostEdgeFaults = 3;

// Returns an error with a reason of import_mesh().
Error mesh_fault(const MeshFile& file, const std::string& reason, const std::string& message) {
  Error error = file.refuse("", message);
  error.reason = reason;
  return error;
}

}  // namespace

void FaceRepair::add(std::int32_t face, std::span<const std::int32_t> vertices) {
  Polygon polygon{static_cast<std::int32_t>(faces_.vertices.size()), 0, face};
  const std::size_t count = vertices.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (vertices[i] == vertices[(i + count - 1) % count]) continue;
    faces_.vertices.push_back(vertices[i]);
    faces_.file_corners.push_back(file_.faces[face].first_corner + static_cast<std::int32_t>(i));
    ++polygon.count;
  }
  faces_.polygons.push_back(polygon);
  if (polygon.count < 3) without_corners_.push_back(static_cast<std::int32_t>(faces_.polygons.size()) - 1);
}

std::int32_t FaceRepair::after(const Polygon& polygon, std::int32_t corner) const {
  return corner + 1 == polygon.first + polygon.count ? polygon.first : corner + 1;
}

void FaceRepair::remove(const std::vector<bool>& is_removed, const std::string& why) {
  std::vector<std::int32_t> names;
  std::vector<Polygon> kept;
  for (std::size_t p = 0; p < faces_.polygons.size(); ++p) {
    if (is_removed[p]) {
      names.push_back(faces_.polygons[p].face);
    } else {
      kept.push_back(faces_.polygons[p]);
    }
  }
  if (names.empty()) return;
  faces_.polygons = std::move(kept);
  notes_.push_back("left out " + file_.face_names(names) + ": " + why);
}

void FaceRepair::leave_out_lines(const OrderOnLine& order_on_line) {
  std::vector<bool> is_line(faces_.polygons.size());
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<std::int32_t>> inside;  // corners, from low to high
  for (const std::int32_t p : without_corners_) is_line[static_cast<std::size_t>(p)] = true;
  for (std::size_t p = 0; p < faces_.polygons.size(); ++p) {
    interruption_point();
    const Polygon& polygon = faces_.polygons[p];
    const std::vector<std::int32_t> order = is_line[p] ? std::vector<std::int32_t>() : order_on_line(polygon);
    if (order.empty()) continue;
    is_line[p] = true;
    std::vector<std::size_t> rank(order.size());  // by corner of the polygon
    for (std::size_t i = 0; i < order.size(); ++i) rank[static_cast<std::size_t>(order[i] - polygon.first)] = i;
    for (std::int32_t c = polygon.first; c < polygon.first + polygon.count; ++c) {
      const auto [low, high] = std::minmax(rank[static_cast<std::size_t>(c - polygon.first)],
                                           rank[static_cast<std::size_t>(after(polygon, c) - polygon.first)]);
      std::vector<std::int32_t> between(order.begin() + static_cast<std::ptrdiff_t>(low) + 1,
                                        order.begin() + static_cast<std::ptrdiff_t>(high));
      if (between.empty()) continue;
      const std::int32_t from = faces_.vertices[order[low]], to = faces_.vertices[order[high]];
      if (from > to) std::reverse(between.begin(), between.end());
      inside[std::minmax(from, to)] = std::move(between);
    }
  }
  remove(is_line, "no area");
  if (inside.empty()) return;
  FacePolygons mended;
  for (const Polygon& polygon : faces_.polygons) {
    Polygon made{static_cast<std::int32_t>(mended.vertices.size()), 0, polygon.face};
    const auto append = [&](std::int32_t corner, std::int32_t file_corner) {
      mended.vertices.push_back(faces_.vertices[corner]);
      mended.file_corners.push_back(file_corner);
      ++made.count;
    };
    for (std::int32_t c = polygon.first; c < polygon.first + polygon.count; ++c) {
      append(c, faces_.file_corners[c]);
      const std::int32_t from = faces_.vertices[c], to = faces_.vertices[after(polygon, c)];
      const auto found = inside.find(std::minmax(from, to));
      if (found == inside.end()) continue;
      std::vector<std::int32_t> corners = found->second;
      if (from > to) std::reverse(corners.begin(), corners.end());
      for (const std::int32_t corner : corners) append(corner, faces_.file_corners[corner]);
    }
    mended.polygons.push_back(made);
  }
  faces_ = std::move(mended);
}

void FaceRepair::leave_out_copies() {
  std::vector<std::int32_t> sorted = faces_.vertices;
  std::vector<std::int32_t> order;
  for (std::size_t p = 0; p < faces_.polygons.size(); ++p) {
    const Polygon& polygon = faces_.polygons[p];
    std::sort(sorted.begin() + polygon.first, sorted.begin() + polygon.first + polygon.count);
    order.push_back(static_cast<std::int32_t>(p));
  }
  const auto corners = [&](std::int32_t p) {
    const Polygon& polygon = faces_.polygons[p];
    return std::span(sorted.data() + polygon.first, static_cast<std::size_t>(polygon.count));
  };
  const auto compare = [&](std::int32_t a, std::int32_t b) {
    const auto x = corners(a), y = corners(b);
    return std::lexicographical_compare_three_way(x.begin(), x.end(), y.begin(), y.end());
  };
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    interruption_point();
    const auto compared = compare(a, b);
    return compared < 0 || (compared == 0 && a < b);
  });
  std::vector<bool> is_copy(faces_.polygons.size());
  for (std::size_t i = 1; i < order.size(); ++i) {
    is_copy[static_cast<std::size_t>(order[i])] = compare(order[i - 1], order[i]) == 0;
  }
  remove(is_copy, "the same corners as another face");
}

std::vector<FaceRepair::Side> FaceRepair::sorted_sides() const {
  std::vector<Side> sides;
  sides.reserve(faces_.vertices.size());
  for (std::size_t p = 0; p < faces_.polygons.size(); ++p) {
    const Polygon& polygon = faces_.polygons[p];
    for (std::int32_t c = polygon.first; c < polygon.first + polygon.count; ++c) {
      const std::int32_t from = faces_.vertices[c], to = faces_.vertices[after(polygon, c)];
      sides.push_back({std::min(from, to), std::max(from, to), static_cast<std::int32_t>(p), c, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
  });
  return sides;
}

std::string FaceRepair::edge_name(const Side& side) const {
  const auto name = [this](std::int32_t corner) {
    return file_.vertex_name(static_cast<std::size_t>(file_.corners[faces_.file_corners[corner]].first));
  };
  return "the edge between " + name(side.corner) + " and " + name(after(faces_.polygons[side.polygon], side.corner));
}

// Adds the faults of edges with more than two polygons. Returns true if there are any.
bool FaceRepair::refuse_crowded_edges(const std::vector<Side>& sides, const std::string& hint) {
  std::size_t num_crowded = 0;
  for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
    interruption_point();
    for (j = i; j < sides.size() && sides[j].low == sides[i].low && sides[j].high == sides[i].high;) ++j;
    if (j - i < 3 || ++num_crowded > kMostEdgeFaults) continue;
    std::vector<std::int32_t> names;
    for (std::size_t k = i; k < j; ++k) names.push_back(faces_.polygons[sides[k].polygon].face);
    const auto twice = std::adjacent_find(names.begin(), names.end());
    if (twice != names.end()) {
      faults_.add(mesh_fault(file_, "MESH_NON_MANIFOLD_EDGE",
                             file_.face_name(static_cast<std::size_t>(*twice)) + " passes more than once along " +
                                 edge_name(sides[i]) + ": leave out the corners that lead there and back"));
      continue;
    }
    faults_.add(mesh_fault(file_, "MESH_NON_MANIFOLD_EDGE",
                           std::to_string(j - i) + " faces meet at " + edge_name(sides[i]) + ": " +
                               file_.face_names(names) + "; a sheet has two at most: remove the others" + hint));
  }
  return num_crowded > 0;
}

void FaceRepair::orient(const std::string& hint) {
  const std::vector<Side> sides = sorted_sides();
  if (refuse_crowded_edges(sides, hint)) return;
  struct Neighbour {
    std::int32_t polygon = kNone;
    std::size_t side = 0;
    bool is_opposed = false;  // both run along the edge in the same direction
  };
  std::vector<Neighbour> beyond(faces_.vertices.size());  // by corner
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const Side &a = sides[i - 1], &b = sides[i];
    if (a.low != b.low || a.high != b.high) continue;
    const bool is_opposed = a.is_upward == b.is_upward;
    beyond[static_cast<std::size_t>(a.corner)] = {b.polygon, i, is_opposed};
    beyond[static_cast<std::size_t>(b.corner)] = {a.polygon, i, is_opposed};
  }
  std::vector<int> turn(faces_.polygons.size(), 0);  // 1: as in the file, -1: turned round, 0: not visited
  std::vector<bool> is_turned(faces_.polygons.size());
  std::vector<std::int32_t> component;
  for (std::size_t first = 0; first < turn.size(); ++first) {
    if (turn[first] != 0) continue;
    component.assign(1, static_cast<std::int32_t>(first));
    turn[first] = 1;
    std::size_t num_turned = 0;
    for (std::size_t next = 0; next < component.size(); ++next) {
      interruption_point();
      const std::int32_t p = component[next];
      const Polygon& polygon = faces_.polygons[p];
      if (turn[p] < 0) ++num_turned;
      for (std::int32_t c = polygon.first; c < polygon.first + polygon.count; ++c) {
        const Neighbour& other = beyond[static_cast<std::size_t>(c)];
        if (other.polygon == kNone) continue;
        const int wanted = other.is_opposed ? -turn[p] : turn[p];
        if (turn[other.polygon] == 0) {
          turn[other.polygon] = wanted;
          component.push_back(other.polygon);
        } else if (turn[other.polygon] != wanted) {
          const std::vector<std::int32_t> names{polygon.face, faces_.polygons[other.polygon].face};
          return faults_.add(mesh_fault(
              file_, "MESH_INCONSISTENT_ORIENTATION",
              "the surface has one side only, as a Moebius strip: it turns over from one to the other of " +
                  file_.face_names(names) + " at " + edge_name(sides[other.side]) + "; cut it open there" + hint));
        }
      }
    }
    const int minority = 2 * num_turned > component.size() ? 1 : -1;
    for (const std::int32_t p : component) is_turned[static_cast<std::size_t>(p)] = turn[p] == minority;
  }
  turn_round(is_turned);
}

void FaceRepair::turn_round(const std::vector<bool>& is_turned) {
  std::vector<std::int32_t> names;
  for (std::size_t p = 0; p < faces_.polygons.size(); ++p) {
    if (!is_turned[p]) continue;
    const Polygon& polygon = faces_.polygons[p];
    names.push_back(polygon.face);
    const auto reverse = [&](std::vector<std::int32_t>& values) {  // the first corner stays the first
      std::reverse(values.begin() + polygon.first + 1, values.begin() + polygon.first + polygon.count);
    };
    reverse(faces_.vertices);
    reverse(faces_.file_corners);
  }
  if (!names.empty()) notes_.push_back("turned round " + file_.face_names(names) + ", to face as its neighbours do");
}

std::vector<std::int32_t> FaceRepair::fans() const {
  Groups groups(faces_.vertices.size());
  const std::vector<Side> sides = sorted_sides();
  for (std::size_t i = 1; i < sides.size(); ++i) {
    interruption_point();
    const Side &a = sides[i - 1], &b = sides[i];
    if (a.low != b.low || a.high != b.high) continue;
    const std::int32_t end_of_a = after(faces_.polygons[a.polygon], a.corner);
    const std::int32_t end_of_b = after(faces_.polygons[b.polygon], b.corner);
    groups.join(a.corner, a.is_upward == b.is_upward ? b.corner : end_of_b);
    groups.join(end_of_a, a.is_upward == b.is_upward ? end_of_b : b.corner);
  }
  std::vector<std::int32_t> fans;
  for (std::size_t c = 0; c < faces_.vertices.size(); ++c)
    fans.push_back(groups.first_of(static_cast<std::int32_t>(c)));
  return fans;
}

}  // namespace kerf::mesh
