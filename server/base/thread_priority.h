#pragma once

namespace kerf {

// Has the calling thread give way to threads of the usual priority, for the rest of its life. Nothing where the system
// refuses.
void lower_thread_priority();

}  // namespace kerf
