#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/base/result.h"

// kerf::Error as google.rpc.Status, the form that standard gRPC and HTTP clients read.
namespace kerf::wire {

// What a client is told to wait before it repeats a request that met a limit: a few ticks.
inline constexpr std::chrono::milliseconds kRetryDelay{100};

// The number of a gRPC status code, 1..16 (https://grpc.io/docs/guides/status-codes/), and its name.
std::int32_t status_code(ErrorCode code);
std::string_view status_name(ErrorCode code);  // "INVALID_ARGUMENT"

// A serialised google.rpc.Status: code, message, and as details ErrorInfo{reason, domain "kerf"}, BadRequest where the
// error names a field, RetryInfo{kRetryDelay} where passes_by_itself(). For the trailer grpc-status-details-bin.
std::string encode_status(const Error& error);

// Of limits: whether the same request may be taken soon, though nothing of it changes, as others end or make room.
bool passes_by_itself(const Error& error);

// The JSON form of the same message: {"code":3,"message":"...","details":[{"@type":"...ErrorInfo",...},...]}.
std::string error_to_json(const Error& error);

}  // namespace kerf::wire
