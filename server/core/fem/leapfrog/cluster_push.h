#pragma once

#include <cstddef>
#include <vector>

#include "server/core/fem/model/inertia_cluster.h"
#include "server/core/linear/lanes16.h"

namespace kerf::fem {

// Pushes vertices of a cluster as a body requires, by impulses j = s M wanted. All vertices respond by W j, W = M'^-1.
// The scale s = (wanted, M wanted) / (M wanted, W M wanted) is a step of steepest descent. An impulse that stops
// vertices never adds energy by M', nor does a smaller s. It is exact for one vertex, and for a free cluster that is
// pushed as a whole. No pushed vertex responds by more than the largest wanted change. Displacements are found in the
// same way. The remainder of both is left to the next substep.
template <typename T>
class ClusterPush {
 public:
  void reserve(std::size_t num_vertices);
  // `wanted` has x, y, z and a fourth number for each of the cluster's vertices, 0 for those not pushed, aligned to 64
  // bytes. Returns the resulting change of all of them, 0 in held components, valid until the next call.
  const T* respond(const InertiaCluster& cluster, const T* wanted);

 private:
  std::vector<linear::Lanes16<T>> impulse_, response_;  // x 4, of one cluster
};

}  // namespace kerf::fem
