#pragma once

namespace kerf {

// Lowers the calling thread's priority below the usual one, for the rest of its life. Does nothing if the system
// refuses.
void lower_thread_priority();

}  // namespace kerf
