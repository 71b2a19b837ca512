#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace kerf {

// A 64-bit hash of plain values in order, to compare states bit for bit. Equal bytes in equal order give equal hashes
// on every machine of the same byte order. It is not for security. Each 64-bit word takes two multiplications;
// constants are those of Stafford's variant 13 of the MurmurHash3 finaliser.
class StateHash {
 public:
  void add(std::uint64_t word) {
    word *= 0xbf58476d1ce4e5b9ULL;
    word ^= word >> 29;
    hash_ = std::rotl(hash_ ^ word, 27) * 0x94d049bb133111ebULL + 0x9e3779b97f4a7c15ULL;
  }
  void add(std::int64_t value) { add(static_cast<std::uint64_t>(value)); }
  void add(std::int32_t value) { add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value))); }
  void add(std::uint32_t value) { add(static_cast<std::uint64_t>(value)); }
  void add(bool value) { add(static_cast<std::uint64_t>(value ? 1 : 0)); }
  // Adds the bits of the value: -0.0 and 0.0 differ, as do NaNs with different bits.
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }

  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void add_span(std::span<const T> values) {
    add(static_cast<std::uint64_t>(values.size()));
    const auto bytes = std::as_bytes(values);
    std::size_t at = 0;
    for (; at + 8 <= bytes.size(); at += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + at, 8);
      add(word);
    }
    if (at < bytes.size()) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + at, bytes.size() - at);
      add(word);
    }
  }

  [[nodiscard]] std::uint64_t value() const {
    std::uint64_t h = hash_;
    h ^= h >> 30;
    h *= 0xbf58476d1ce4e5b9ULL;
    h ^= h >> 27;
    h *= 0x94d049bb133111ebULL;
    return h ^ (h >> 31);
  }

 private:
  std::uint64_t hash_ = 0x6b657266;  // "kerf"
};

}  // namespace kerf
