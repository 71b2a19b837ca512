#include "server/service/host/entropy.h"

#include <random>

namespace kerf::host {

std::uint64_t SystemEntropy::next() {
  std::random_device device;  // One per call: std::random_device promises no thread safety.
  const std::uint64_t high = device();
  return (high << 32U) ^ device();
}

std::uint64_t SeededEntropy::next() {
  const std::lock_guard lock(mutex_);
  return random_.next();
}

}  // namespace kerf::host
