#pragma once

namespace kerf {

// Lowers the priority of the calling thread below the default until the thread ends. Does nothing if the system
// refuses.
void lower_thread_priority();

}  // namespace kerf
