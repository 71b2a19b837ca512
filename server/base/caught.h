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

// What `work`, which makes a Result, returns; or the error that tells of an exception that comes out of it:
// kResourceExhausted OUT_OF_MEMORY, kAborted INTERRUPTED (see interruption_point()), kInternal INTERNAL. For work whose
// memory is as large as a client's sheet: what one of them is too large for must not end the server of all.
template <typename Work>
std::invoke_result_t<Work> caught(Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const Interrupted&) {
    return aborted("INTERRUPTED", "the work was ended before it was done");
  } catch (const std::exception& error) {
    return internal_error("INTERNAL", error.what());
  }
}

}  // namespace kerf
