#pragma once

namespace kerf {

// Prints the failed condition and where it stands to stderr, then aborts. A broken invariant is our bug: continuing
// would corrupt what users see. What the network sends is never checked with this (see Result).
[[noreturn]] void check_failed(const char* condition, const char* file, int line, const char* message);

}  // namespace kerf

// Always on.
#define KERF_CHECK(condition, message)                                                 \
  do {                                                                                 \
    if (!(condition)) ::kerf::check_failed(#condition, __FILE__, __LINE__, (message)); \
  } while (false)

// For hot loops: on unless NDEBUG.
#ifdef NDEBUG
#define KERF_DCHECK(condition, message) \
  do {                                  \
  } while (false)
#else
#define KERF_DCHECK(condition, message) KERF_CHECK(condition, message)
#endif
