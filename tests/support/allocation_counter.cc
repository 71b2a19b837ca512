#include "tests/support/allocation_counter.h"

#include <cerrno>
#include <cstdlib>

namespace kerf::test {

static std::size_t allocation_count = 0;
static std::size_t allocation_bytes = 0;

std::size_t num_allocations() {
  return allocation_count;
}
std::size_t allocated_bytes() {
  return allocation_bytes;
}

#ifdef KERF_SANITIZED
bool counts_allocations() {
  return false;
}
#else
bool counts_allocations() {
  return true;
}
static void count(std::size_t bytes) {
  ++allocation_count;
  allocation_bytes += bytes;
}
#endif

}  // namespace kerf::test

#ifndef KERF_SANITIZED
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
