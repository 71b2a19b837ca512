#include "client/cpp/failure.h"

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace kerf::client {

namespace {

// Adds the remedy to gRPC's own refusals, which name none.
void explain(Failure& failure) {
  if (failure.code == grpc::StatusCode::RESOURCE_EXHAUSTED &&
      failure.message.find("larger than max") != std::string::npos) {
    failure.reason = "MESSAGE_TOO_LARGE";
    failure.message += ": send less in one call, for example a batch of cuts in parts, or a mesh file as an upload";
  }
  if (failure.code == grpc::StatusCode::DEADLINE_EXCEEDED) {
    failure.reason = "NO_ANSWER_IN_TIME";
    failure.message =
        "no answer in time: a tick of the sheet may take long. The request may still be carried out: check before you "
        "repeat it";
  }
  if (failure.code == grpc::StatusCode::UNAVAILABLE) {
    const auto says = [&](const char* words) { return failure.message.find(words) != std::string::npos; };
    if (says("SSL_ERROR_SSL") || says("is not in peer certificate")) {
      failure.reason = "TLS_FAILED";
      failure.message =
          "TLS with the server failed: its certificate is of another authority or for another name, or it has no TLS "
          "(" +
          failure.message + ")";
    }
  }
}

}  // namespace

Failure failure_of(const grpc::Status& status) {
  Failure failure{status.error_code(), {}, status.error_message(), {}};
  google::rpc::Status details;
  if (status.error_details().empty()) explain(failure);
  if (!details.ParseFromString(status.error_details())) return failure;
  for (const google::protobuf::Any& detail : details.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::BadRequest bad;
    if (detail.Is<google::rpc::ErrorInfo>() && detail.UnpackTo(&info)) failure.reason = info.reason();
    if (detail.Is<google::rpc::BadRequest>() && detail.UnpackTo(&bad) && bad.field_violations_size() > 0) {
      failure.field = bad.field_violations(0).field();
    }
  }
  return failure;
}

std::string reason_of(const grpc::Status& status) {
  const Failure failure = failure_of(status);
  if (!failure.reason.empty()) return failure.reason;
  return failure.message.empty() ? name_of(failure.code) : name_of(failure.code) + ": " + failure.message;
}

std::string name_of(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::OK:
      return "OK";
    case grpc::StatusCode::CANCELLED:
      return "CANCELLED";
    case grpc::StatusCode::INVALID_ARGUMENT:
      return "INVALID_ARGUMENT";
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return "DEADLINE_EXCEEDED";
    case grpc::StatusCode::NOT_FOUND:
      return "NOT_FOUND";
    case grpc::StatusCode::ALREADY_EXISTS:
      return "ALREADY_EXISTS";
    case grpc::StatusCode::PERMISSION_DENIED:
      return "PERMISSION_DENIED";
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return "RESOURCE_EXHAUSTED";
    case grpc::StatusCode::FAILED_PRECONDITION:
      return "FAILED_PRECONDITION";
    case grpc::StatusCode::ABORTED:
      return "ABORTED";
    case grpc::StatusCode::OUT_OF_RANGE:
      return "OUT_OF_RANGE";
    case grpc::StatusCode::UNIMPLEMENTED:
      return "UNIMPLEMENTED";
    case grpc::StatusCode::INTERNAL:
      return "INTERNAL";
    case grpc::StatusCode::UNAVAILABLE:
      return "UNAVAILABLE";
    case grpc::StatusCode::DATA_LOSS:
      return "DATA_LOSS";
    case grpc::StatusCode::UNAUTHENTICATED:
      return "UNAUTHENTICATED";
    default:
      return "UNKNOWN";
  }
}

std::string describe(const Failure& failure) {
  std::string line = failure.message;
  if (!failure.field.empty()) line += " [field: " + failure.field + "]";
  line += " (" + name_of(failure.code);
  if (!failure.reason.empty()) line += ", " + failure.reason;
  return line + ")";
}

}  // namespace kerf::client
