#pragma once

#include <Eigen/Core>

#include "server/base/random.h"

namespace kerf::contact {

// Components from -extent to extent.
inline Eigen::Vector3d random_vector(SeededRandom& random, double extent) {
  const double x = random.uniform(-extent, extent);
  const double y = random.uniform(-extent, extent);
  return {x, y, random.uniform(-extent, extent)};
}

}  // namespace kerf::contact
