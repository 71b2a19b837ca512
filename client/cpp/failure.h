#pragma once

#include <string>

#include <grpcpp/support/status.h>

namespace kerf::client {

// Why a call was refused, for people and for programs.
struct Failure {
  grpc::StatusCode code = grpc::StatusCode::UNKNOWN;
  std::string reason;   // stable, e.g. "CURVE_NOT_FINITE"; empty where the server gave none (it was not reached, say)
  std::string message;  // what is wrong and what to do
  std::string field;    // path of the offending request field; may be empty
};

// Reads google.rpc.Status out of the trailing metadata that gRPC keeps in `status`. `status` must not be OK.
Failure failure_of(const grpc::Status& status);

// "INVALID_ARGUMENT" and so on.
std::string name_of(grpc::StatusCode code);

// The server's reason, or where it gave none the code's name and gRPC's words: short, and the same for the same thing.
// Of a status that is not OK.
std::string reason_of(const grpc::Status& status);

// One line: message, field, code.
std::string describe(const Failure& failure);

}  // namespace kerf::client
