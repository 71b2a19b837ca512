#pragma once

#include <chrono>
#include <thread>

namespace kerf::test {

/**
 * Waits for what the test can only ask for, such as a counter of a server. Asks every 2 ms, so that the processors are
 * free for the server. The time limit of ctest ends a wait in vain.
 */
template <typename Condition>
void wait_until(const Condition& condition) {
  while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

}  // namespace kerf::test
