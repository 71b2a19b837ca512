#pragma once

#include <future>
#include <memory>
#include <utility>

#include "server/base/result.h"

namespace kerf::app {

// Blocks until a call of the host is answered. For a server that listens on no transport yet.
template <typename T, typename Start>
Result<T> wait_for(const Start& start) {
  const auto promise = std::make_shared<std::promise<Result<T>>>();
  std::future<Result<T>> future = promise->get_future();
  start([promise](Result<T> result) { promise->set_value(std::move(result)); });
  return future.get();
}

}  // namespace kerf::app
