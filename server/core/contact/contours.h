#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/sheet_features.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::contact {

// An edge that passes through a triangle.
struct Piercing {
  std::int32_t edge = 0, triangle = 0;  // of SheetFeatures
  // -, unit: the way on which the edge leaves the triangle, relative to it; 0 if none is known.
  Eigen::Vector3d way{0.0, 0.0, 0.0};
};

// Tells which way triangles that pass through each other come apart.
//
// Triangles that pass through each other share segments, which line up in contours. A contour that cuts a part off a
// sheet is left by that part, if it is the smaller one: its edges go back through the triangles that they pierce
// (Baraff, Witkin, Kass 2003, "Untangling Cloth"). Other contours begin at the border of one part and end at that of
// the other. Where edges have only just passed, their nearer ends go back. Elsewhere both parts slide along the contour
// as makes it shorter (Volino, Magnenat-Thalmann 2006, "Resolving Surface Collisions through Intersection Contour
// Minimization").
class ContourFinder {
 public:
  // Fills `piercings` with those of pairs of triangles at positions x (m), ordered by edge and triangle. The result
  // depends on nothing else.
  void find(const SheetFeatures& features, std::span<const std::array<std::int32_t, 2>> pairs,
            const linear::VertexField& x, std::vector<Piercing>& piercings);

 private:
  // One of at most two pairs of triangles that have a piercing.
  struct Incidence {
    std::int32_t edge = 0, triangle = 0, pair = 0;
  };
  // A region that a contour bounds; the root stands for united ones.
  struct Region {
    std::int32_t parent = 0;
    std::int32_t size = 0;    // vertices
    std::int32_t ended = -1;  // level at which it stopped growing; -1: it grows
    bool is_growing = false;
  };

  void list_incidences(const SheetFeatures& features, std::span<const std::array<std::int32_t, 2>> pairs,
                       const linear::VertexField& x);
  // Numbers the contours, and tells for each pair of triangles on which side of its contour the first one is.
  void find_contours(std::span<const std::array<std::int32_t, 2>> pairs, std::span<const Piercing> piercings);
  std::int32_t root_of(std::int32_t pair);
  std::int32_t region_of(std::int32_t region);
  // Grows regions on both sides of the edges that a contour pierces, until it is known of each what it is cut off.
  void grow_regions(const SheetFeatures& features, std::span<const std::int32_t> contour,
                    std::span<const Piercing> piercings);
  // Sets the way of an edge that the contour cuts in two different regions, and returns true if it does.
  bool leads_back(const SheetFeatures& features, const linear::VertexField& x, Piercing& of);
  void set_ways(const SheetFeatures& features, std::span<const std::array<std::int32_t, 2>> pairs,
                std::span<const std::int32_t> contour, const linear::VertexField& x, std::span<Piercing> piercings);
  // Returns the gradient of the contour's length with respect to the place of the edge, turned over.
  [[nodiscard]] Eigen::Vector3d shortening(const SheetFeatures& features,
                                           std::span<const std::array<std::int32_t, 2>> pairs, std::int32_t piercing,
                                           const linear::VertexField& x, std::span<const Piercing> piercings) const;

  std::vector<Incidence> incidences_;          // ordered by edge, triangle, pair
  std::vector<std::int32_t> first_incidence_;  // by piercing, and one more
  std::vector<std::int32_t> parent_;           // by pair: a forest of contours
  std::vector<std::uint8_t> is_turned_;        // by pair: its first triangle is on the other side than its parent's
  std::vector<std::int32_t> order_;            // piercings, by contour
  std::vector<std::int32_t> contour_of_;       // by piercing: a pair
  std::vector<std::uint8_t> is_second_;        // by piercing: its edge is on the second side of the contour
  std::vector<std::uint8_t> is_cut_;           // by edge: pierced an odd number of times by the contour
  std::vector<std::int32_t> region_;           // by vertex id; -1: none
  std::vector<Region> regions_;
  std::vector<mesh::VertexId> grown_;  // vertices with a region, level by level
};

}  // namespace kerf::contact
