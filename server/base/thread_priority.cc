#include "server/base/thread_priority.h"

#include <sys/resource.h>

namespace kerf {

// Linux has a niceness for each thread: see setpriority(2), "C library/kernel differences".
void lower_thread_priority() {
  constexpr int kNiceness = 10;
  setpriority(PRIO_PROCESS, 0, kNiceness);
}

}  // namespace kerf
