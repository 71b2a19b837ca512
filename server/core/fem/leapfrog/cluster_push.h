#pragma once

#include <cstddef>
#include <vector>

#include "server/core/fem/model/inertia_cluster.h"
#include "server/core/linear/lanes16.h"

namespace kerf::fem {

// Pushes the vertices of a cluster on which a body acts. `wanted` is the change of velocity that the body requires of
// each of them, and the impulses are j = s M wanted. All vertices of the cluster respond by W j, W = M'^-1. The scale s
// = (wanted, M wanted) / (M wanted, W M wanted) is a step of steepest descent. If the impulse only stops vertices it
// adds no kinetic energy by M', and neither does a smaller s. The response is exact for one vertex, and for a free
// cluster that is pushed as a whole. s is reduced if a pushed vertex would respond by more than the largest wanted
// change. Changes of position are found in the same way. What is missing from the wanted changes is left to the next
// substep.
template <typename T>
class ClusterPush {
 public:
  void reserve(std::size_t num_vertices);
  // `wanted` has x, y, z and a fourth number for each vertex of the cluster, all 0 if it is not pushed; it is aligned
  // to 64 bytes. Returns the resulting change of each vertex in the same layout, 0 in held components. It is valid
  // until the next call.
  const T* respond(const InertiaCluster& cluster, const T* wanted);

 private:
  std::vector<linear::Lanes16<T>> impulse_, response_;  // x 4, of one cluster
};

}  // namespace kerf::fem
