#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/core/mesh/triangle_mesh.h"

// Curves of the kinds that the thesis cuts with. It gives pictures of them and no coordinates, so these are Kerf's own,
// of the sizes that it prints. All lie in the unit square.
namespace kerf::evaluation {

// Kinds of figure 5.1: (a) straight, (b) smooth, (c) cornered, (d) like a flower.
enum class Kind { kStraight, kCurve, kZigzag, kFlower };

struct CrossedRange {
  int least = 0, most = 0;  // triangles of the uncut sheet that the curve runs through
};

// Returns a curve of a kind that crosses a number of triangles of `sheet` in the given range. It is turned by up to 5
// degrees, moved by up to 0.02 and scaled by up to 3 %, by `seed`; drawn again until it fits.
cut::Curve random_curve(Kind kind, const mesh::TriangleMesh& sheet, CrossedRange range, std::uint32_t seed);

// Families of figures 5.7 and 5.8: `size` in 0..1 makes them larger.
std::vector<cut::Curve> single_cut(double size);
std::vector<cut::Curve> intersecting_cuts(double size);
std::vector<cut::Curve> multiple_cuts(double size);

// Number of triangles of the sheet that a curve crosses.
int count_crossed(const mesh::TriangleMesh& sheet, const cut::Curve& curve);

}  // namespace kerf::evaluation
