#pragma once

#include <cstdint>
#include <mutex>

#include "server/base/random.h"

namespace kerf::host {

// Provides the server's only randomness, for the names of sheets and the id of each start of the server. Never part of
// a simulation. Thread-safe.
class Entropy {
 public:
  virtual ~Entropy() = default;
  // Returns 64 random bits.
  virtual std::uint64_t next() = 0;
};

// Draws random bits from the operating system.
class SystemEntropy : public Entropy {
 public:
  std::uint64_t next() override;
};

// Gives the same sequence for the same seed.
class SeededEntropy : public Entropy {
 public:
  explicit SeededEntropy(std::uint64_t seed) : random_(seed) {}
  std::uint64_t next() override;

 private:
  std::mutex mutex_;
  SeededRandom random_;
};

}  // namespace kerf::host
