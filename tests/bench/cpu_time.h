#pragma once

#include <ctime>

namespace kerf::bench {

inline double cpu_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Returns the CPU time of the calling thread, s.
inline double thread_cpu_s() {
  return cpu_s(CLOCK_THREAD_CPUTIME_ID);
}

// Returns the CPU time of all threads, s.
inline double process_cpu_s() {
  return cpu_s(CLOCK_PROCESS_CPUTIME_ID);
}

}  // namespace kerf::bench
