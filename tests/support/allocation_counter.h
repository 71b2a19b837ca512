#pragma once

// Counts every allocation of the program it is included in, Eigen's included (which calls malloc, not operator new). To
// be included by one source of a test. glibc only; counts nothing under a sanitizer, which has its own malloc.

#include <cerrno>
#include <cstddef>
#include <cstdlib>

namespace kerf::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kCountsAllocations = false;
inline std::size_t num_allocations() {
  return 0;
}
inline std::size_t allocated_bytes() {
  return 0;
}
#else
inline constexpr bool kCountsAllocations = true;
inline std::size_t allocation_count = 0;  // the tests have one thread
inline std::size_t allocation_bytes = 0;  // asked for, given back or not
inline std::size_t num_allocations() {
  return allocation_count;
}
inline std::size_t allocated_bytes() {
  return allocation_bytes;
}
inline void count(std::size_t bytes) {
  ++allocation_count;
  allocation_bytes += bytes;
}
#endif

}  // namespace kerf::test

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  kerf::test::count(size);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  kerf::test::count(count * size);
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  kerf::test::count(size);
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  kerf::test::count(size);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  kerf::test::count(size);
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}
}
#endif
