#include "server/service/wire/error_codec.h"

#include <set>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/base/check.h"
#include "server/service/wire/json.h"

namespace kerf::wire {
namespace {

struct CodeName {
  std::int32_t number;
  std::string_view name;
};

CodeName code_name(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return {3, "INVALID_ARGUMENT"};
    case ErrorCode::kNotFound:
      return {5, "NOT_FOUND"};
    case ErrorCode::kAlreadyExists:
      return {6, "ALREADY_EXISTS"};
    case ErrorCode::kResourceExhausted:
      return {8, "RESOURCE_EXHAUSTED"};
    case ErrorCode::kFailedPrecondition:
      return {9, "FAILED_PRECONDITION"};
    case ErrorCode::kAborted:
      return {10, "ABORTED"};
    case ErrorCode::kPermissionDenied:
      return {7, "PERMISSION_DENIED"};
    case ErrorCode::kUnauthenticated:
      return {16, "UNAUTHENTICATED"};
    case ErrorCode::kInternal:
      return {13, "INTERNAL"};
    case ErrorCode::kUnavailable:
      return {14, "UNAVAILABLE"};
    case ErrorCode::kDataLoss:
      return {15, "DATA_LOSS"};
  }
  KERF_CHECK(false, "an ErrorCode outside its enumeration");
}

// Begins the field of an error that is about a tenant, and no field of the request.
constexpr std::string_view kQuotaSubject = "tenant:";

google::rpc::Status to_status(const Error& error) {
  google::rpc::Status status;
  status.set_code(status_code(error.code));
  status.set_message(error.message);
  google::rpc::ErrorInfo info;
  info.set_reason(error.reason);
  info.set_domain("kerf");
  status.add_details()->PackFrom(info);
  if (error.field.starts_with(kQuotaSubject)) {
    google::rpc::QuotaFailure failure;
    google::rpc::QuotaFailure::Violation* violation = failure.add_violations();
    violation->set_subject(error.field);
    violation->set_description(error.message);
    status.add_details()->PackFrom(failure);
  } else if (!error.field.empty()) {
    google::rpc::BadRequest request;
    google::rpc::BadRequest::FieldViolation* violation = request.add_field_violations();
    violation->set_field(error.field);
    violation->set_description(error.message);
    status.add_details()->PackFrom(request);
  }
  if (passes_by_itself(error)) {
    google::rpc::RetryInfo retry;
    retry.mutable_retry_delay()->set_nanos(static_cast<std::int32_t>(std::chrono::nanoseconds(kRetryDelay).count()));
    status.add_details()->PackFrom(retry);
  }
  return status;
}

}  // namespace

bool passes_by_itself(const Error& error) {
  static const std::set<std::string_view> reasons = {"BACKUP_UNDER_WAY",
                                                     "OVERLOADED",
                                                     "QUEUE_FULL",
                                                     "STORAGE_FULL",
                                                     "TENANT_CUTS",
                                                     "TENANT_IMAGE_STREAMS",
                                                     "TENANT_LOAD",
                                                     "TENANT_SHEETS",
                                                     "TENANT_STREAMS",
                                                     "TOO_MANY_ANALYSES",
                                                     "TOO_MANY_CONNECTIONS",
                                                     "TOO_MANY_FILES",
                                                     "TOO_MANY_PICTURES",
                                                     "TOO_MANY_RECORDINGS",
                                                     "TOO_MANY_SCHEDULED",
                                                     "TOO_MANY_SHEETS",
                                                     "TOO_MANY_STORE_CALLS",
                                                     "TOO_MANY_UPLOADS",
                                                     "TOO_MANY_SUBSCRIBERS",
                                                     "TOO_MANY_IMAGE_STREAMS",
                                                     "TOO_MANY_VERTICES_IN_ALL"};
  if (error.code == ErrorCode::kUnavailable) return error.reason == "STORAGE_STALLED";
  return error.code == ErrorCode::kResourceExhausted && reasons.contains(error.reason);
}

std::int32_t status_code(ErrorCode code) {
  return code_name(code).number;
}

std::string_view status_name(ErrorCode code) {
  return code_name(code).name;
}

std::string encode_status(const Error& error) {
  return to_status(error).SerializeAsString();
}

std::string error_to_json(const Error& error) {
  return to_json(to_status(error));
}

}  // namespace kerf::wire
