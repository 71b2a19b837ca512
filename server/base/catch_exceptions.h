#pragma once

#include <exception>
#include <new>
#include <type_traits>
#include <utility>

#include "server/base/interruption.h"
#include "server/base/result.h"

namespace kerf {

inline Error out_of_memory() {
  return resource_exhausted("OUT_OF_MEMORY",
                            "the server has too little memory left for this; delete sheets, or try a smaller one");
}

// Calls `work`, which returns a Result, and turns an exception into an error: kResourceExhausted OUT_OF_MEMORY,
// kAborted INTERRUPTED (see interruption_point()) or kInternal INTERNAL. Put it around work whose memory grows with a
// client's sheet, so that one sheet too large does not end the server for all clients.
template <typename Work>
std::invoke_result_t<Work> catch_exceptions(Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const Interrupted&) {
    return aborted("INTERRUPTED", "the work was stopped before it finished");
  } catch (const std::exception& error) {
    return internal_error("INTERNAL", error.what());
  }
}

}  // namespace kerf
