#pragma once

#include <cstddef>
#include <vector>

#include "server/core/fem/model/inertia_cluster.h"
#include "server/core/linear/lanes16.h"

namespace kerf::fem {

// Pushes vertices of a cluster as a body wants, by impulses j = s M wanted. All of them respond by W j, W = M'^-1. The
// scale s = (wanted, M wanted) / (M wanted, W M wanted) is a step of steepest descent: what stops vertices never adds
// energy by M', nor does a smaller s. It is exact for one vertex, and for a free cluster that is pushed as a whole. No
// pushed vertex responds by more than the largest that is wanted. Displacements are found in the same way. The next
// substep asks for what is left of both.
template <typename T>
class ClusterPush {
 public:
  void reserve(std::size_t num_vertices);
  // wanted: x, y, z and one more of each of the cluster's vertices, 0 of those that are not pushed, aligned to 64
  // bytes. Returns what that changes of all of them, valid until the next call; 0 where it is held.
  const T* respond(const InertiaCluster& cluster, const T* wanted);

 private:
  std::vector<Lanes16<T>> impulse_, response_;  // x 4, of one cluster
};

}  // namespace kerf::fem
