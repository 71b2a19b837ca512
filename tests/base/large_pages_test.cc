// Linked with kerf::allocation, as the programs are.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace {

constexpr std::size_t kLargePage = std::size_t{2} << 20;

std::uintptr_t address_of(const void* block) {
  return reinterpret_cast<std::uintptr_t>(block);
}

TEST(LargePages, LargeBlocksBeginOnOneAndKeepTheirContents) {
  std::vector<std::int64_t> numbers;
  for (const std::size_t size : {std::size_t{1} << 19, std::size_t{1} << 20, (std::size_t{1} << 20) + 1}) {
    numbers.resize(size);
    numbers.shrink_to_fit();
    EXPECT_EQ(address_of(numbers.data()) % kLargePage, 0U) << size;
    std::iota(numbers.begin(), numbers.end(), 0);
    numbers.resize(2 * size);
    EXPECT_EQ(std::accumulate(numbers.begin(), numbers.end(), std::int64_t{0}),
              static_cast<std::int64_t>(size) * static_cast<std::int64_t>(size - 1) / 2);
  }
}

TEST(LargePages, EveryFormGivesWhatWasAskedFor) {
  struct alignas(256) Wide {
    double value = 1.0;
  };
  for (const std::size_t count : {std::size_t{1}, std::size_t{3}, std::size_t{40'000}}) {
    const std::vector<Wide> wide(count);
    EXPECT_EQ(address_of(wide.data()) % alignof(Wide), 0U) << count;
    const auto array = std::make_unique<Wide[]>(count);
    EXPECT_EQ(address_of(array.get()) % alignof(Wide), 0U) << count;
  }
  const std::unique_ptr<char> nothing(static_cast<char*>(::operator new(0)));
  EXPECT_NE(nothing, nullptr);
}

TEST(LargePages, TooMuchIsRefusedAsTheStandardSays) {
  const auto keep = [](void* block) { EXPECT_EQ(block, nullptr); };  // so that no compiler leaves the allocation out
  // Beyond what can be rounded up, and what rounds up but is not there.
  for (const std::size_t bytes : {std::numeric_limits<std::size_t>::max(), std::size_t{1} << 62}) {
    EXPECT_THROW(keep(::operator new(bytes)), std::bad_alloc);
    EXPECT_EQ(::operator new(bytes, std::nothrow), nullptr);
  }
  static int calls = 0;
  calls = 0;
  std::set_new_handler([] {
    if (++calls == 3) std::set_new_handler(nullptr);
  });
  EXPECT_THROW(keep(::operator new (std::size_t{1} << 62)), std::bad_alloc);
  EXPECT_EQ(calls, 3);
}

}  // namespace
