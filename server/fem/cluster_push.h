#pragma once

#include <cstddef>
#include <vector>

#include "server/fem/inertia_cluster.h"
#include "server/fem/lanes16.h"

namespace kerf::fem {

// Pushes vertices of a cluster as a body wants, by impulses j in proportion to their masses and to what is wanted of
// each: j_i = s m_i wanted_i, s such that the cluster responds to them as wanted on average, (wanted, M W j) = (wanted,
// M wanted), W = M'^-1. Exact for one vertex and for a free cluster that is pushed as a whole. This is a step of
// steepest descent to j with (W j)_i = wanted_i: what stops vertices never adds energy by M'. Displacements are found
// alike, and what is left of both is wanted again in the next substep.
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
