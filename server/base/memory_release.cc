#include "server/base/memory_release.h"

#include <malloc.h>

namespace kerf {

void release_free_memory() {
  malloc_trim(0);
}

}  // namespace kerf
