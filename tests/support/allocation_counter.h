#pragma once

// Counts every allocation of a program that links kerf_allocation_counter, Eigen's included (which calls malloc, not
// operator new). glibc only; counts nothing under a sanitizer, which has its own malloc.

#include <cstddef>

namespace kerf::test {

bool counts_allocations();

// Allocations so far, and the bytes asked for, given back or not. The tests have one thread.
std::size_t num_allocations();
std::size_t allocated_bytes();

}  // namespace kerf::test
