#pragma once

extern "C" {
void __asan_init() __attribute__((weak));  // NOLINT: the sanitizers' own names
void __tsan_init() __attribute__((weak));  // NOLINT
}

namespace kerf::test {

// True in a program with a sanitizer, which has its own malloc and reserves address space. Tests are compiled without
// it, so that no macro tells whether there is one.
inline bool runs_with_sanitizer() {
  return __asan_init != nullptr || __tsan_init != nullptr;
}

}  // namespace kerf::test
