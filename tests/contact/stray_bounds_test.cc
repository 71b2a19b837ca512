#include "server/core/contact/stray_bounds.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

linear::VertexField random_field(SeededRandom& random, Eigen::Index count) {
  linear::VertexField field;
  field.resize(count);
  for (Eigen::Index v = 0; v < count; ++v) field.col(v) = random_vector(random, 1.0);
  return field;
}

TEST(FindStray, BoundsWhatEachVertexHasOnTopOfTheMean) {
  SeededRandom random(1);
  for (const Eigen::Index count : {1, 2, 7, 8, 9, 16, 40, 333}) {
    const linear::VertexField x = random_field(random, count), v = random_field(random, count);
    const linear::VertexField line_x = random_field(random, count), line_v = random_field(random, count);
    for (const double ahead : {0.0, 0.25}) {
      const Stray stray = find_stray(x, v, {line_x, line_v}, 0.5, ahead);
      const linear::VertexField way = x + ahead * v - line_x - (0.5 + ahead) * line_v;
      const Eigen::Vector3d mean = way.rowwise().mean();
      EXPECT_TRUE(stray.mean.isApprox(mean, 1e-13)) << count;
      const double farthest = (way.colwise() - mean).colwise().norm().maxCoeff();
      EXPECT_GE(stray.most, farthest - 1e-14) << count;
      EXPECT_LE(stray.most, std::max(2.0 * farthest, 1e-14)) << count;
    }
  }
}

}  // namespace
}  // namespace kerf::contact
