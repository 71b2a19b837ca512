#pragma once

#include <cstdint>

namespace kerf {

// The random generator SplitMix64 (Steele, Lea, Flood 2014): seedable, and the same sequence on every machine. It is
// the only source of randomness in server/core. Functions get it as an argument; there is no global one.
class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  // Returns a number in [0, 1) with 53 random bits.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  // Returns a number in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  // Returns a number in [0, bound), bound > 0. Its bias, at most bound / 2^64, does not matter here.
  std::uint64_t below(std::uint64_t bound) { return next() % bound; }

 private:
  std::uint64_t state_;
};

}  // namespace kerf
