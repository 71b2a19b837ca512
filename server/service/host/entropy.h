#pragma once

#include <cstdint>
#include <mutex>

#include "server/base/random.h"

namespace kerf::host {

// All that the server knows of chance: names of sheets and of the server's run. Never part of a simulation.
// Thread-safe.
class Entropy {
 public:
  virtual ~Entropy() = default;
  // 64 random bits.
  virtual std::uint64_t next() = 0;
};

// From the operating system.
class SystemEntropy : public Entropy {
 public:
  std::uint64_t next() override;
};

// The same sequence for the same seed.
class SeededEntropy : public Entropy {
 public:
  explicit SeededEntropy(std::uint64_t seed) : random_(seed) {}
  std::uint64_t next() override;

 private:
  std::mutex mutex_;
  SeededRandom random_;
};

}  // namespace kerf::host
