#pragma once

#include <cstdint>
#include <string>

#include <benchmark/benchmark.h>

// Results that benchmarks must reproduce, in expected_hashes.json beside this file.
namespace kerf::bench {

// Compares with the stored hash of that name; a difference fails the benchmark and the program. With update mode on it
// stores the hash instead.
void expect_hash(benchmark::State& state, const std::string& name, std::uint64_t hash);

void set_update_mode();
// Writes what update mode gathered. Returns the exit code of the program: 1 where a hash differed.
int finish();

}  // namespace kerf::bench
