#pragma once

namespace kerf {

// Gives freed memory back to the system; the C library would keep it for later allocations. Takes milliseconds per GB,
// during which allocations of other threads may wait.
void release_free_memory();

}  // namespace kerf
