#pragma once

#include <string>

#include <grpcpp/support/status.h>

namespace kerf::client {

// Describes why a call was refused, for people and for programs.
struct Failure {
  grpc::StatusCode code = grpc::StatusCode::UNKNOWN;
  std::string reason;   // Stable, e.g. "CURVE_NOT_FINITE"; empty if the server gave none (it was not reached, say).
  std::string message;  // Fault and remedy.
  std::string field;    // Path of the offending request field; may be empty.
};

// Reads google.rpc.Status from the trailing metadata that gRPC keeps in `status`. `status` must not be OK.
Failure failure_of(const grpc::Status& status);

// Returns the name of a code, e.g. "INVALID_ARGUMENT".
std::string name_of(grpc::StatusCode code);

// Returns the server's reason; without one, the code's name and gRPC's words. The text is short, and equal for equal
// faults. `status` must not be OK.
std::string reason_of(const grpc::Status& status);

// Returns one line: message, field, code.
std::string describe(const Failure& failure);

}  // namespace kerf::client
