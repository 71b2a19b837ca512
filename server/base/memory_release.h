#pragma once

namespace kerf {

// Gives memory that was freed back to the system, which the C library keeps for later otherwise. Takes milliseconds for
// each GB, in which allocations of other threads may wait.
void release_free_memory();

}  // namespace kerf
