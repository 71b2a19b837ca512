// Replaces the global allocation functions of programs that link this file, so that large blocks lie on large pages.
//
// A cut touches a few hundred places of a sheet. On a sheet of hundreds of megabytes in pages of 4 KiB, translating an
// address costs about as much as reading there. In pages of 2 MiB it costs hardly anything. Linux uses large pages by
// itself if transparent_hugepage is "always" and the alignment allows it. If it is "madvise", it does so on request.

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kLargePage = std::size_t{2} << 20;  // bytes
constexpr std::size_t kLargeBlock = 2 * kLargePage;       // bytes; smaller blocks would waste too much by rounding

constexpr std::size_t rounded_up(std::size_t bytes, std::size_t unit) {
  return (bytes + unit - 1) / unit * unit;
}

void* try_to_allocate(std::size_t bytes, std::size_t alignment) {
  if (bytes >= kLargeBlock && bytes <= SIZE_MAX - kLargePage) {
    const std::size_t rounded = rounded_up(bytes, kLargePage);
    void* const block = std::aligned_alloc(std::max(kLargePage, alignment), rounded);
    if (block != nullptr) madvise(block, rounded, MADV_HUGEPAGE);  // may fail: small pages work too
    return block;
  }
  if (alignment <= alignof(std::max_align_t)) return std::malloc(bytes);
  return std::aligned_alloc(alignment, rounded_up(bytes, alignment));
}

void* allocate(std::size_t bytes, std::size_t alignment) {
  bytes = std::max<std::size_t>(bytes, 1);
  for (;;) {
    if (void* const block = try_to_allocate(bytes, alignment); block != nullptr) return block;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

}  // namespace

// The standard library's other forms (for arrays, nothrow, sized) call these functions.
void* operator new(std::size_t bytes) {
  return allocate(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept {
  std::free(block);
}
void operator delete(void* block, std::align_val_t /*alignment*/) noexcept {
  std::free(block);
}
void operator delete(void* block, std::size_t /*bytes*/) noexcept {
  std::free(block);
}
void operator delete(void* block, std::size_t /*bytes*/, std::align_val_t /*alignment*/) noexcept {
  std::free(block);
}
