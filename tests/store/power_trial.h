#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/store/lossy_disk.h"

namespace kerf::test {

// Faults of a program that lets losses of power destroy what it promised.
enum class PowerFault { kNone, kNoFolderSync, kNoLogSync };

struct PowerRun {
  std::int64_t num_operations = 0;  // of the disk, in the life that power ended or in the whole of it
  std::int64_t num_answered = 0;    // callbacks
  std::vector<std::string> losses;  // promises that were broken, a sentence each
};

// Runs a random workload on a store, and lets power fail before the disk's operation `power_ends`. Opens what is left
// and compares it with what was answered. Does this three times, each on what the time before left; the later losses
// come at random operations. The same arguments do the same.
PowerRun run_power_trial(std::uint64_t seed, std::int64_t power_ends, PowerFault fault = PowerFault::kNone);

}  // namespace kerf::test
