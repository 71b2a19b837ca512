#pragma once

#include <stdexcept>
#include <utility>
#include <variant>

#include "client/cpp/failure.h"

namespace kerf::client {

// Thrown by value() of a failed Result; what() is describe(failure).
class CallFailed : public std::runtime_error {
 public:
  explicit CallFailed(Failure reason) : std::runtime_error(describe(reason)), failure(std::move(reason)) {}
  const Failure failure;
};

struct Done {};

// Holds the value of a call, or why it was refused. A refusal has changed nothing.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(google-explicit-constructor)
  Result(Failure failure)
      : content_(std::in_place_index<1>, std::move(failure)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return content_.index() == 0; }
  explicit operator bool() const { return ok(); }

  // Return the value. Without one they throw CallFailed, for programs that cannot continue after a failure.
  T& value() & { return got(*this); }
  [[nodiscard]] const T& value() const& { return got(*this); }
  T&& value() && { return std::move(got(*this)); }
  T& operator*() & { return got(*this); }
  const T& operator*() const& { return got(*this); }
  T* operator->() { return &got(*this); }
  const T* operator->() const { return &got(*this); }

  // Returns the failure; for refused calls only.
  [[nodiscard]] const Failure& failure() const { return std::get<1>(content_); }

 private:
  template <typename Self>
  static auto& got(Self& self) {
    if (!self.ok()) throw CallFailed(self.failure());
    return std::get<0>(self.content_);
  }

  std::variant<T, Failure> content_;
};

}  // namespace kerf::client
