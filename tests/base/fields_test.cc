#include "server/base/fields.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace kerf {
namespace {

struct Leaf {
  std::int32_t number = 0;
  std::optional<double> length;
  bool operator==(const Leaf&) const = default;
};

struct Tree {
  std::string name;
  bool is_green = false;
  std::array<bool, 2> has{};
  std::vector<Leaf> leaves;
  std::vector<std::pair<std::int32_t, std::uint8_t>> pairs;
  std::shared_ptr<const Leaf> shared;
};

}  // namespace
}  // namespace kerf

template <>
struct kerf::Fields<kerf::Leaf> {
  static auto of(auto& of) {
    auto& [number, length] = of;
    return std::tie(number, length);
  }
};
template <>
struct kerf::Fields<kerf::Tree> {
  static auto of(auto& of) {
    auto& [name, is_green, has, leaves, pairs, shared] = of;
    return std::tie(name, is_green, has, leaves, pairs, shared);
  }
};

namespace kerf {
namespace {

Tree tree() {
  return {"oak", true, {false, true}, {{1, 2.5}, {-3, {}}}, {{7, 8}}, std::make_shared<const Leaf>(Leaf{9, 0.5})};
}

template <class T>
std::string written(const T& value) {
  FieldWriter writer;
  visit(writer, value);
  return writer.bytes();
}

template <class T>
std::uint64_t hash_of(const T& value) {
  FieldHasher hasher;
  visit(hasher, value);
  return hasher.value();
}

TEST(Fields, AreReadAsTheyWereWritten) {
  const std::string bytes = written(tree());
  FieldReader reader(bytes);
  Tree read;
  visit(reader, read);
  EXPECT_TRUE(reader.is_done());
  EXPECT_EQ(read.name, "oak");
  EXPECT_TRUE(read.is_green);
  EXPECT_EQ(read.has, (std::array<bool, 2>{false, true}));
  EXPECT_EQ(read.leaves, tree().leaves);
  EXPECT_EQ(read.pairs, tree().pairs);
  EXPECT_EQ(*read.shared, *tree().shared);
  EXPECT_EQ(written(read), bytes);
  EXPECT_EQ(hash_of(read), hash_of(tree()));
}

TEST(Fields, AreLittleEndianWithTheirCountBefore) {
  EXPECT_EQ(written(std::vector<std::int32_t>{1, 258}), std::string("\2\0\0\0\0\0\0\0\1\0\0\0\2\1\0\0", 16));
  EXPECT_EQ(written(std::optional<std::uint8_t>{7}), std::string("\1\7", 2));
  EXPECT_EQ(written(std::optional<std::uint8_t>{}), std::string("\0", 1));
}

TEST(Fields, EachCountsInTheHash) {
  const std::uint64_t hash = hash_of(tree());
  const auto changed = [&](const auto& change) {
    Tree other = tree();
    change(other);
    return hash_of(other) != hash;
  };
  EXPECT_TRUE(changed([](Tree& of) { of.name = "elm"; }));
  EXPECT_TRUE(changed([](Tree& of) { of.has[0] = true; }));
  EXPECT_TRUE(changed([](Tree& of) { of.leaves[1].length = 0.0; }));
  EXPECT_TRUE(changed([](Tree& of) { of.leaves.pop_back(); }));
  EXPECT_TRUE(changed([](Tree& of) { of.shared = nullptr; }));
}

TEST(Fields, ThatAreCutShortAreAFault) {
  const std::string bytes = written(tree());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    FieldReader reader(std::string_view(bytes).substr(0, size));
    Tree read;
    visit(reader, read);
    EXPECT_TRUE(reader.failed()) << size;
  }
  const std::string more = bytes + "x";
  FieldReader longer(more);
  Tree read;
  visit(longer, read);
  EXPECT_FALSE(longer.failed());
  EXPECT_FALSE(longer.is_done());
}

TEST(Fields, AClaimedCountTakesNoMemory) {
  for (const std::uint64_t count : {std::uint64_t{1} << 60U, ~std::uint64_t{0}, std::uint64_t{3}}) {
    const std::string bytes = written(count) + "12345678";
    FieldReader numbers(bytes);
    std::vector<double> read;
    visit(numbers, read);
    EXPECT_TRUE(numbers.failed());
    EXPECT_EQ(read.capacity(), 0U);
    FieldReader objects(bytes);
    std::vector<Leaf> leaves;
    visit(objects, leaves);
    EXPECT_TRUE(objects.failed());
    EXPECT_LE(leaves.capacity(), 4U);
  }
}

TEST(Fields, AFlagIsNoughtOrOne) {
  FieldReader reader("\2");
  bool value = true;
  visit(reader, value);
  EXPECT_TRUE(reader.failed());
  EXPECT_FALSE(value);
}

}  // namespace
}  // namespace kerf
