#pragma once

#include <string>
#include <utility>
#include <variant>

#include "server/base/check.h"

namespace kerf {

// The few kinds of refusal there are, named as the gRPC status they become on the wire.
enum class ErrorCode {
  kInvalidArgument,     // would never work, whatever the state
  kNotFound,            // names something that does not exist
  kAlreadyExists,       // names something that does
  kResourceExhausted,   // a limit or a full queue; may work later
  kFailedPrecondition,  // right request, wrong state
  kAborted,             // lost a race
  kUnavailable,         // shutting down, or not there (no renderer)
  kDataLoss,            // stored state is damaged
  kInternal,            // our bug
};

// A refusal that says what to do next. `field` is the path of the offending request field, empty where there is none.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string reason;   // UPPER_SNAKE_CASE, stable, for programs, e.g. "CURVE_NOT_FINITE"
  std::string message;  // for people: what is wrong, with the number and the limit
  std::string field;    // e.g. "cut.bezier.points[2].x"
};

inline Error invalid_argument(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kInvalidArgument, std::move(reason), std::move(message), std::move(field)};
}

// A value or an Error. No exception crosses a module boundary; this does.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return content_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & {
    KERF_CHECK(ok(), "value() of a failed Result");
    return *std::get_if<0>(&content_);
  }
  [[nodiscard]] const T& value() const& {
    KERF_CHECK(ok(), "value() of a failed Result");
    return *std::get_if<0>(&content_);
  }
  T&& value() && {
    KERF_CHECK(ok(), "value() of a failed Result");
    return std::move(*std::get_if<0>(&content_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  [[nodiscard]] const Error& error() const {
    KERF_CHECK(!ok(), "error() of a successful Result");
    return *std::get_if<1>(&content_);
  }

 private:
  std::variant<T, Error> content_;
};

struct Nothing {};
using Status = Result<Nothing>;

}  // namespace kerf
