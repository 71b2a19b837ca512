#pragma once

namespace kerf {

// Prints the failed condition, its file and its line to stderr, then aborts. A broken invariant is a bug of Kerf, and
// continuing would corrupt what users see. Input from the network is never checked with this: it gets an Error (see
// Result).
[[noreturn]] void check_failed(const char* condition, const char* file, int line, const char* message);

}  // namespace kerf

// Checks an invariant in every build.
#define KERF_CHECK(condition, message)                                                 \
  do {                                                                                 \
    if (!(condition)) ::kerf::check_failed(#condition, __FILE__, __LINE__, (message)); \
  } while (false)

// Checks an invariant in a hot loop, in builds without NDEBUG only.
#ifdef NDEBUG
#define KERF_DCHECK(condition, message) \
  do {                                  \
  } while (false)
#else
#define KERF_DCHECK(condition, message) KERF_CHECK(condition, message)
#endif
