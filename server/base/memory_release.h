#pragma once

namespace kerf {

// Returns freed memory, which the C library otherwise keeps for later, to the system. Takes milliseconds per GB, during
// which allocations of other threads may wait.
void release_free_memory();

}  // namespace kerf
