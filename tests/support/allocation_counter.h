#pragma once

// Counts every allocation of a program that links kerf_allocation_counter, Eigen's included (which calls malloc, not
// operator new). glibc only; counts nothing under a sanitizer, which has its own malloc.

#include <cstddef>

namespace kerf::test {

bool counts_allocations();

// Return the number of allocations so far, freed or not, and the bytes requested by them. For tests with one thread.
std::size_t num_allocations();
std::size_t allocated_bytes();

}  // namespace kerf::test
