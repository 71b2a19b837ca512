#pragma once

#include <string>
#include <utility>
#include <variant>

namespace kerf {

// Kinds of errors, named as the gRPC status codes that they become on the wire.
enum class ErrorCode {
  kInvalidArgument,     // would never work, whatever the state
  kNotFound,            // names something that does not exist
  kAlreadyExists,       // names something that exists already
  kResourceExhausted,   // a limit or a full queue; may work later
  kFailedPrecondition,  // right request, wrong state
  kAborted,             // a concurrent change or an interruption came first
  kUnauthenticated,     // who asks is not known
  kPermissionDenied,    // who asks is known, and may not
  kUnavailable,         // shutting down, or not there (no renderer)
  kDataLoss,            // stored state is damaged
  kInternal,            // a bug of Kerf
};

// An error, with a message that states the remedy. `field` is the path of the offending field in the request, or empty.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string reason;   // UPPER_SNAKE_CASE, stable, for programs, e.g. "CURVE_NOT_FINITE"
  std::string message;  // for people: the fault, with the value and its limit
  std::string field;    // e.g. "cut.bezier.points[2].x"
};

// Make an Error with the code of that name. `reason`, `message` and `field` are the members of Error.
inline Error invalid_argument(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kInvalidArgument, std::move(reason), std::move(message), std::move(field)};
}
inline Error not_found(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kNotFound, std::move(reason), std::move(message), std::move(field)};
}
inline Error already_exists(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kAlreadyExists, std::move(reason), std::move(message), std::move(field)};
}
inline Error resource_exhausted(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kResourceExhausted, std::move(reason), std::move(message), std::move(field)};
}
inline Error failed_precondition(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kFailedPrecondition, std::move(reason), std::move(message), std::move(field)};
}
inline Error aborted(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kAborted, std::move(reason), std::move(message), std::move(field)};
}
inline Error unauthenticated(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kUnauthenticated, std::move(reason), std::move(message), std::move(field)};
}
inline Error permission_denied(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kPermissionDenied, std::move(reason), std::move(message), std::move(field)};
}
inline Error unavailable(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kUnavailable, std::move(reason), std::move(message), std::move(field)};
}
inline Error data_loss(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kDataLoss, std::move(reason), std::move(message), std::move(field)};
}
inline Error internal_error(std::string reason, std::string message, std::string field = {}) {
  return {ErrorCode::kInternal, std::move(reason), std::move(message), std::move(field)};
}

// Prints `message` to stderr and aborts. Called when a Result is read without asking ok() first.
[[noreturn]] void wrong_result_access(const char* message);

// A value or an Error. Modules report errors with it; no exception crosses a module boundary.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return content_.index() == 0; }

  T& value() & {
    if (!ok()) wrong_result_access("value() of a failed Result");
    return *std::get_if<0>(&content_);
  }
  [[nodiscard]] const T& value() const& {
    if (!ok()) wrong_result_access("value() of a failed Result");
    return *std::get_if<0>(&content_);
  }
  T&& value() && {
    if (!ok()) wrong_result_access("value() of a failed Result");
    return std::move(*std::get_if<0>(&content_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  [[nodiscard]] const Error& error() const {
    if (ok()) wrong_result_access("error() of a successful Result");
    return *std::get_if<1>(&content_);
  }

 private:
  std::variant<T, Error> content_;
};

struct Nothing {};
using Status = Result<Nothing>;

}  // namespace kerf

// Evaluates an expression that gives a Result of any type. Returns its error from the enclosing function, if it has
// one.
#define KERF_TRY(...)                                                                        \
  do {                                                                                       \
    if (const auto& kerf_tried = (__VA_ARGS__); !kerf_tried.ok()) return kerf_tried.error(); \
  } while (false)

// Returns the error of an expression as KERF_TRY does. Otherwise moves its value into the first argument, a declaration
// or a variable:
//   KERF_TRY_ASSIGN(const mesh::TriangleMesh mesh, make_mesh(config));
#define KERF_TRY_ASSIGN(target, ...) KERF_TRY_ASSIGN_AS(KERF_JOINED(kerf_tried_, __LINE__), target, __VA_ARGS__)
#define KERF_TRY_ASSIGN_AS(result, target, ...) \
  auto result = (__VA_ARGS__);                  \
  if (!result.ok()) return result.error();      \
  target = std::move(result).value()  // NOLINT(bugprone-macro-parentheses): may be a declaration
#define KERF_JOINED(first, second) KERF_JOINED_AS_THEY_ARE(first, second)
#define KERF_JOINED_AS_THEY_ARE(first, second) first##second
