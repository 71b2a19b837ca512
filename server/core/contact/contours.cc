#include "server/core/contact/contours.h"

#include <algorithm>
#include <tuple>

#include <Eigen/Geometry>

#include "server/core/contact/orient3d.h"

namespace kerf::contact {

using mesh::VertexId;

namespace {

using Pairs = std::span<const std::array<std::int32_t, 2>>;

Eigen::Vector3d at(const linear::VertexField& x, VertexId v) {
  return x.col(v);
}

Eigen::Vector3d normal_of(const std::array<VertexId, 3>& corners, const linear::VertexField& x) {
  return (at(x, corners[1]) - at(x, corners[0])).cross(at(x, corners[2]) - at(x, corners[0])).normalized();
}

bool pierces(const std::array<VertexId, 2>& edge, const std::array<VertexId, 3>& corners,
             const linear::VertexField& x) {
  const Eigen::Vector3d p = x.col(edge[0]), q = x.col(edge[1]);
  const Eigen::Vector3d a = x.col(corners[0]), b = x.col(corners[1]), c = x.col(corners[2]);
  if (orient3d(a, b, c, p) * orient3d(a, b, c, q) >= 0) return false;
  const int ab = orient3d(p, q, a, b), bc = orient3d(p, q, b, c), ca = orient3d(p, q, c, a);
  return std::max({ab, bc, ca}) - std::min({ab, bc, ca}) < 2;
}

}  // namespace

std::int32_t ContourFinder::root_of(std::int32_t pair) {
  const auto i = static_cast<std::size_t>(pair);
  const std::int32_t above = parent_[i];
  if (above == pair) return pair;
  const std::int32_t root = root_of(above);
  // The parity of `above` is now that against the root.
  if (above != root) is_turned_[i] ^= is_turned_[static_cast<std::size_t>(above)];
  parent_[i] = root;
  return root;
}

std::int32_t ContourFinder::region_of(std::int32_t region) {
  std::int32_t& parent = regions_[static_cast<std::size_t>(region)].parent;
  if (parent != region) parent = region_of(parent);
  return parent;
}

void ContourFinder::list_incidences(const SheetFeatures& features, Pairs pairs, const linear::VertexField& x) {
  incidences_.clear();
  const auto add = [&](std::int32_t of, std::int32_t through, std::size_t pair) {
    const std::array<VertexId, 3>& corners = features.triangles[static_cast<std::size_t>(of)].vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId from = corners[k], to = corners[(k + 1) % 3];
      const std::span<const VertexId> neighbours = features.neighbours_of(from);
      const auto place = std::find(neighbours.begin(), neighbours.end(), to) - neighbours.begin();
      const std::int32_t edge = features.edges_of(from)[static_cast<std::size_t>(place)];
      const SheetFeatures::Edge& found = features.edges[static_cast<std::size_t>(edge)];
      if (pierces(found.vertices, features.triangles[static_cast<std::size_t>(through)].vertices, x)) {
        incidences_.push_back({edge, through, static_cast<std::int32_t>(pair)});
      }
    }
  };
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    add(pairs[p][0], pairs[p][1], p);
    add(pairs[p][1], pairs[p][0], p);
  }
  std::sort(incidences_.begin(), incidences_.end(), [](const Incidence& a, const Incidence& b) {
    return std::tie(a.edge, a.triangle, a.pair) < std::tie(b.edge, b.triangle, b.pair);
  });
}

void ContourFinder::find_contours(Pairs pairs, std::span<const Piercing> piercings) {
  parent_.resize(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) parent_[p] = static_cast<std::int32_t>(p);
  is_turned_.assign(pairs.size(), 0);
  const auto is_second = [&](std::int32_t pair, const Piercing& of) {
    return static_cast<std::uint8_t>(pairs[static_cast<std::size_t>(pair)][0] == of.triangle ? 1 : 0);
  };
  for (std::size_t k = 0; k < piercings.size(); ++k) {
    const auto begin = static_cast<std::size_t>(first_incidence_[k]);
    for (auto i = begin + 1; i < static_cast<std::size_t>(first_incidence_[k + 1]); ++i) {
      const std::int32_t a = incidences_[begin].pair, b = incidences_[i].pair;
      const std::int32_t root_a = root_of(a), root_b = root_of(b);
      if (root_a == root_b) continue;
      const auto low = static_cast<std::size_t>(std::min(root_a, root_b));
      const auto high = static_cast<std::size_t>(std::max(root_a, root_b));
      is_turned_[high] = is_second(a, piercings[k]) ^ is_second(b, piercings[k]) ^
                         is_turned_[static_cast<std::size_t>(a)] ^ is_turned_[static_cast<std::size_t>(b)];
      parent_[high] = static_cast<std::int32_t>(low);
    }
  }
  order_.resize(piercings.size());
  contour_of_.resize(piercings.size());
  is_second_.resize(piercings.size());
  for (std::size_t k = 0; k < piercings.size(); ++k) {
    const std::int32_t pair = incidences_[static_cast<std::size_t>(first_incidence_[k])].pair;
    order_[k] = static_cast<std::int32_t>(k);
    contour_of_[k] = root_of(pair);
    is_second_[k] = is_second(pair, piercings[k]) ^ is_turned_[static_cast<std::size_t>(pair)];
  }
  std::sort(order_.begin(), order_.end(), [this](std::int32_t a, std::int32_t b) {
    return std::tie(contour_of_[static_cast<std::size_t>(a)], a) <
           std::tie(contour_of_[static_cast<std::size_t>(b)], b);
  });
}

void ContourFinder::grow_regions(const SheetFeatures& features, std::span<const std::int32_t> contour,
                                 std::span<const Piercing> piercings) {
  for (const std::int32_t k : contour) {
    is_cut_[static_cast<std::size_t>(piercings[static_cast<std::size_t>(k)].edge)] ^= 1;
  }
  regions_.clear();
  grown_.clear();
  const auto start = [&](VertexId v) {
    std::int32_t& region = region_[static_cast<std::size_t>(v)];
    if (region >= 0) return;
    region = static_cast<std::int32_t>(regions_.size());
    regions_.push_back({region, 1, -1, true});
    grown_.push_back(v);
  };
  const auto is_cut = [&](const Piercing& of) { return is_cut_[static_cast<std::size_t>(of.edge)] != 0; };
  for (const std::int32_t k : contour) {
    const Piercing& of = piercings[static_cast<std::size_t>(k)];
    if (!is_cut(of)) continue;
    for (const VertexId v : features.edges[static_cast<std::size_t>(of.edge)].vertices) start(v);
  }
  const auto root = [&](VertexId v) { return region_of(region_[static_cast<std::size_t>(v)]); };
  const auto is_known = [&](std::int32_t k) {
    const Piercing& of = piercings[static_cast<std::size_t>(k)];
    if (!is_cut(of)) return true;
    const auto& [a, b] = features.edges[static_cast<std::size_t>(of.edge)].vertices;
    const std::int32_t first = root(a), second = root(b);
    return first == second || regions_[static_cast<std::size_t>(first)].ended >= 0 ||
           regions_[static_cast<std::size_t>(second)].ended >= 0;
  };
  std::size_t begin = 0;
  for (std::int32_t level = 0; begin < grown_.size(); ++level) {
    const std::size_t end = grown_.size();
    for (; begin < end; ++begin) {
      const VertexId v = grown_[begin];
      const std::span<const VertexId> neighbours = features.neighbours_of(v);
      const std::span<const std::int32_t> edges = features.edges_of(v);
      for (std::size_t i = 0; i < neighbours.size(); ++i) {
        if (is_cut_[static_cast<std::size_t>(edges[i])] != 0) continue;
        std::int32_t& there = region_[static_cast<std::size_t>(neighbours[i])];
        const std::int32_t here = root(v);
        if (there < 0) {
          there = here;
          ++regions_[static_cast<std::size_t>(here)].size;
          grown_.push_back(neighbours[i]);
          continue;
        }
        const std::int32_t other = region_of(there), low = std::min(here, other), high = std::max(here, other);
        if (low == high) continue;
        regions_[static_cast<std::size_t>(high)].parent = low;
        regions_[static_cast<std::size_t>(low)].size += regions_[static_cast<std::size_t>(high)].size;
      }
    }
    for (Region& region : regions_) region.is_growing = false;
    for (std::size_t i = end; i < grown_.size(); ++i)
      regions_[static_cast<std::size_t>(root(grown_[i]))].is_growing = true;
    for (Region& region : regions_) {
      if (!region.is_growing && region.ended < 0) region.ended = level;
    }
    if (std::all_of(contour.begin(), contour.end(), is_known)) break;
  }
}

Eigen::Vector3d ContourFinder::shortening(const SheetFeatures& features, Pairs pairs, std::int32_t piercing,
                                          const linear::VertexField& x, std::span<const Piercing> piercings) const {
  constexpr double kGrazing = 0.1;  // -, least sine of the angle between edge and triangle
  const auto k = static_cast<std::size_t>(piercing);
  const Piercing& of = piercings[k];
  const std::array<VertexId, 2>& ends = features.edges[static_cast<std::size_t>(of.edge)].vertices;
  const VertexId p = ends[0], q = ends[1];
  const Eigen::Vector3d along = (at(x, q) - at(x, p)).normalized();
  const Eigen::Vector3d normal = normal_of(features.triangles[static_cast<std::size_t>(of.triangle)].vertices, x);
  const bool is_end = first_incidence_[k + 1] - first_incidence_[k] == 1;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (auto i = static_cast<std::size_t>(first_incidence_[k]); i < static_cast<std::size_t>(first_incidence_[k + 1]);
       ++i) {
    const std::array<std::int32_t, 2>& pair = pairs[static_cast<std::size_t>(incidences_[i].pair)];
    const SheetFeatures::Triangle& of_edge =
        features.triangles[static_cast<std::size_t>(pair[0] == of.triangle ? pair[1] : pair[0])];
    const std::array<VertexId, 3>& corners = of_edge.vertices;
    const VertexId third = *std::find_if(corners.begin(), corners.end(), [&](VertexId v) { return v != p && v != q; });
    // Next to a common vertex of two triangles a contour continues between them, although they are no pair.
    const auto corner = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), third) - corners.begin());
    if (is_end && of_edge.across[corner] != mesh::kNone) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d to_third = at(x, third) - at(x, p);
    const Eigen::Vector3d inward = to_third - to_third.dot(along) * along;
    const Eigen::Vector3d segment = normal_of(corners, x).cross(normal).normalized();
    sum += segment.dot(inward) < 0.0 ? Eigen::Vector3d(-segment) : segment;
  }
  const double across = along.dot(normal);
  if (std::abs(across) < kGrazing) return sum;
  return sum - along.dot(sum) / across * normal;
}

bool ContourFinder::leads_back(const SheetFeatures& features, const linear::VertexField& x, Piercing& of) {
  if (is_cut_[static_cast<std::size_t>(of.edge)] == 0) return false;
  const auto& [a, b] = features.edges[static_cast<std::size_t>(of.edge)].vertices;
  const std::int32_t of_a = region_of(region_[static_cast<std::size_t>(a)]);
  const std::int32_t of_b = region_of(region_[static_cast<std::size_t>(b)]);
  if (of_a == of_b) return false;
  const auto rank = [this](std::int32_t region) {
    const Region& known = regions_[static_cast<std::size_t>(region)];
    return std::tuple(known.ended < 0, known.ended, known.size, region);
  };
  const Eigen::Vector3d back = rank(of_a) < rank(of_b) ? at(x, b) - at(x, a) : at(x, a) - at(x, b);
  const Eigen::Vector3d normal = normal_of(features.triangles[static_cast<std::size_t>(of.triangle)].vertices, x);
  of.way = normal.dot(back) < 0.0 ? Eigen::Vector3d(-normal) : normal;
  return true;
}

void ContourFinder::set_ways(const SheetFeatures& features, Pairs pairs, std::span<const std::int32_t> contour,
                             const linear::VertexField& x, std::span<Piercing> piercings) {
  constexpr double kLeastSum = 0.5;  // -, of ways of unit length, below which they cancel out
  constexpr double kShallow = 0.1;   // -, of the extent of a contour, up to which its depth counts as small
  grow_regions(features, contour, piercings);
  // Ways of the first side of the contour relative to the second one: of a part that is cut off, of edges whose nearer
  // ends go back, and along the contour.
  Eigen::Vector3d back = Eigen::Vector3d::Zero(), out = back, shorter = back;
  Eigen::AlignedBox3d extent;
  double depth = 0.0;  // m, of the nearer ends of edges behind triangles, at most
  bool is_cut_off = false;
  const auto side = [this](std::int32_t k) { return is_second_[static_cast<std::size_t>(k)] != 0 ? -1.0 : 1.0; };
  for (const std::int32_t k : contour) {
    Piercing& of = piercings[static_cast<std::size_t>(k)];
    if (leads_back(features, x, of)) {
      is_cut_off = true;
      back += side(k) * of.way;
    }
    shorter += side(k) * shortening(features, pairs, k, x, piercings);
    const std::array<VertexId, 3>& corners = features.triangles[static_cast<std::size_t>(of.triangle)].vertices;
    const auto& [a, b] = features.edges[static_cast<std::size_t>(of.edge)].vertices;
    const Eigen::Vector3d normal = normal_of(corners, x);
    const double height_a = normal.dot(at(x, a) - at(x, corners[0]));
    const double height_b = normal.dot(at(x, b) - at(x, corners[0]));
    // The farther apart the heights are, the more is known.
    const double sum = height_a + height_b, most = std::max(std::abs(height_a), std::abs(height_b));
    if (most > 0.0) out += side(k) * sum / most * normal;
    depth = std::max(depth, std::min(std::abs(height_a), std::abs(height_b)));
    const double part = height_a == height_b ? 0.5 : height_a / (height_a - height_b);
    extent.extend(at(x, a) + part * (at(x, b) - at(x, a)));
  }
  Eigen::Vector3d mean = back;
  if (!is_cut_off || !(back.norm() > kLeastSum)) {
    const bool is_shallow = depth < kShallow * extent.sizes().maxCoeff() && out.norm() > kLeastSum;
    mean = is_shallow ? out : shorter;
  }
  mean = mean.norm() > kLeastSum ? mean.normalized() : Eigen::Vector3d(Eigen::Vector3d::Zero());
  for (const std::int32_t k : contour) {
    Piercing& of = piercings[static_cast<std::size_t>(k)];
    if (of.way.isZero(0.0)) of.way = side(k) * mean;
    is_cut_[static_cast<std::size_t>(of.edge)] = 0;
  }
  for (const VertexId v : grown_) region_[static_cast<std::size_t>(v)] = -1;
}

void ContourFinder::find(const SheetFeatures& features, Pairs pairs, const linear::VertexField& x,
                         std::vector<Piercing>& piercings) {
  list_incidences(features, pairs, x);
  piercings.clear();
  first_incidence_.clear();
  for (std::size_t i = 0; i < incidences_.size(); ++i) {
    const Incidence& each = incidences_[i];
    if (!piercings.empty() && piercings.back().edge == each.edge && piercings.back().triangle == each.triangle)
      continue;
    first_incidence_.push_back(static_cast<std::int32_t>(i));
    piercings.push_back({each.edge, each.triangle});
  }
  first_incidence_.push_back(static_cast<std::int32_t>(incidences_.size()));
  find_contours(pairs, piercings);
  is_cut_.assign(features.edges.size(), 0);
  region_.assign(static_cast<std::size_t>(x.cols()), -1);
  for (std::size_t begin = 0, end = 0; begin < order_.size(); begin = end) {
    const std::int32_t contour = contour_of_[static_cast<std::size_t>(order_[begin])];
    while (end < order_.size() && contour_of_[static_cast<std::size_t>(order_[end])] == contour) ++end;
    set_ways(features, pairs, std::span(order_).subspan(begin, end - begin), x, piercings);
  }
}

}  // namespace kerf::contact
