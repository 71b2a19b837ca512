#include "server/host/metrics.h"

namespace kerf::host {

void DurationHistogram::add(double duration_s) {
  std::size_t bin = 0;
  while (bin < kBounds.size() && duration_s > kBounds[bin]) ++bin;
  ++counts[bin];
  sum_s += duration_s;
  ++total;
}

}  // namespace kerf::host
