#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/base/result.h"

// Encodes kerf::Error as google.rpc.Status, the form that standard gRPC and HTTP clients read.
namespace kerf::wire {

// Suggested delay before a client repeats a request that met a limit: a few ticks.
inline constexpr std::chrono::milliseconds kRetryDelay{100};

// Return the number of a gRPC status code, 1..16 (https://grpc.io/docs/guides/status-codes/), and its name.
std::int32_t status_code(ErrorCode code);
std::string_view status_name(ErrorCode code);  // "INVALID_ARGUMENT"

// Returns a serialised google.rpc.Status for the trailer grpc-status-details-bin. It has code, message and details:
// ErrorInfo{reason, domain "kerf"}, BadRequest if the error names a field, or QuotaFailure if that is "tenant:NAME",
// and RetryInfo{kRetryDelay} if passes_by_itself().
std::string encode_status(const Error& error);

// True if the error reports a limit on things in use at the same time, such as sheets or uploads. It is also true for a
// disk that is full or late. The same request may be accepted soon.
bool passes_by_itself(const Error& error);

// Returns the message of encode_status() as JSON:
// {"code":3,"message":"...","details":[{"@type":"...ErrorInfo",...},...]}.
std::string error_to_json(const Error& error);

}  // namespace kerf::wire
