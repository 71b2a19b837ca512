#include "server/service/host/vertex_budget.h"

#include <algorithm>
#include <string>

namespace kerf::host {

Status VertexBudget::take(std::int64_t more) {
  const std::lock_guard lock(mutex_);
  if (limit_ != 0 && in_use_ + more > limit_) {
    return resource_exhausted("TOO_MANY_VERTICES_IN_ALL",
                              "all sheets of this server together may have " + std::to_string(limit_) +
                                  " vertices and already have " + std::to_string(in_use_) +
                                  ": this one has more than the " +
                                  std::to_string(std::max<std::int64_t>(limit_ - in_use_, 0)) +
                                  " left; delete a sheet, make this one coarser, or give kerfd a larger "
                                  "--max-total-vertices");
  }
  in_use_ += more;
  return Nothing{};
}

void VertexBudget::change(std::int64_t by) {
  const std::lock_guard lock(mutex_);
  in_use_ += by;
}

}  // namespace kerf::host
