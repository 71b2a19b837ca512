#include "server/service/codec/packed_integers.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/base/random.h"

namespace kerf::codec {
namespace {

// Numbers of very different sizes, with runs of zeros.
std::vector<std::uint32_t> some_numbers(SeededRandom& random, std::size_t count) {
  std::vector<std::uint32_t> values(count);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 20 == 0) bits = random.below(34);
    values[i] = bits == 0 ? 0 : static_cast<std::uint32_t>(random.below(std::uint64_t{1} << (bits - 1)));
  }
  return values;
}

TEST(PackedIntegers, HaveTheBytesThatTheHeaderDescribes) {
  // k = 0: 5 bits 0, then 1 0 | 0 | 1 1 0, lowest bit first.
  EXPECT_EQ(pack_integers(std::vector<std::uint32_t>{1, 0, 2}, 1), std::string("\x20\x03", 2));
  // Two columns of zeros: 31, 31.
  EXPECT_EQ(pack_integers(std::vector<std::uint32_t>(32, 0), 2), std::string("\xff\x03", 2));
  EXPECT_EQ(pack_integers({}, 3), "");
}

TEST(PackedIntegers, ComeBackAsTheyWere) {
  SeededRandom random(1);
  for (int round = 0; round < 400; ++round) {
    const std::size_t columns = 1 + random.below(4);
    const std::vector<std::uint32_t> values = some_numbers(random, columns * random.below(70));
    const std::string bytes = pack_integers(values, columns);
    EXPECT_EQ(unpack_integers(bytes, values.size(), columns), values) << "round " << round;
  }
}

TEST(PackedIntegers, TakeTheirEntropyAndLittleMore) {
  SeededRandom random(2);
  std::vector<std::uint32_t> values(16000);
  double entropy_bits = 0.0;
  for (std::uint32_t& value : values) {
    // Geometric, p = 1/9: entropy (-q log2 q - p log2 p) / p bits each.
    while (random.uniform() < 8.0 / 9.0) ++value;
  }
  const double p = 1.0 / 9.0;
  entropy_bits = (-(1 - p) * std::log2(1 - p) - p * std::log2(p)) / p * 16000;
  EXPECT_LT(8.0 * static_cast<double>(pack_integers(values, 1).size()), 1.12 * entropy_bits);
}

TEST(PackedIntegers, EveryCutOffOrLongerStringIsRefused) {
  SeededRandom random(3);
  for (int round = 0; round < 30; ++round) {
    const std::vector<std::uint32_t> values = some_numbers(random, 3 * (1 + random.below(40)));
    const std::string bytes = pack_integers(values, 3);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      EXPECT_EQ(unpack_integers(std::string_view(bytes).substr(0, length), values.size(), 3), std::nullopt);
    }
    EXPECT_EQ(unpack_integers(bytes + '\0', values.size(), 3), std::nullopt);
    EXPECT_EQ(unpack_integers(bytes + '\x7f', values.size(), 3), std::nullopt);
  }
}

TEST(PackedIntegers, AnyBytesAreReadOrRefusedWithinTheirBounds) {
  SeededRandom random(4);
  for (int round = 0; round < 3000; ++round) {
    std::string bytes(random.below(60), '\0');
    for (char& byte : bytes) byte = static_cast<char>(random.below(256));
    const std::size_t count = 2 * random.below(40);
    const auto values = unpack_integers(bytes, count, 2);
    if (values) {
      EXPECT_EQ(values->size(), count);
    }
  }
}

TEST(PackedIntegers, NothingIsAllocatedForNumbersThatCannotBeThere) {
  EXPECT_EQ(unpack_integers("abc", std::size_t{1} << 40, 1), std::nullopt);
}

TEST(PackedIntegers, ZigzagIsItsOwnWayBack) {
  for (const std::int32_t value : {0, 1, -1, 12345, -12345, INT32_MAX, INT32_MIN}) {
    EXPECT_EQ(unzigzag(zigzag(value)), value);
  }
  EXPECT_EQ(zigzag(-1), 1U);
  EXPECT_EQ(zigzag(1), 2U);
}

}  // namespace
}  // namespace kerf::codec
