#include "server/service/api/audit_log.h"

#include <utility>

#include "kerf/v1/access_service.pb.h"
#include "server/service/wire/json.h"

namespace kerf::api {
namespace {

constexpr double kSecondsOfMinute = 60.0;
constexpr std::int64_t kMicroseconds = 1'000'000;

}  // namespace

AuditLog::AuditLog(Append append, host::Clock& clock)
    : append_(std::move(append)),
      clock_(clock),
      refusals_(kRefusalsPerMinute / kSecondsOfMinute, kRefusalsPerMinute, clock.now()) {}

void AuditLog::add(const Entry& entry, const Status& outcome) {
  v1::AuditEntry line;
  line.set_call(entry.call);
  line.set_outcome(outcome.ok() ? "OK" : outcome.error().reason);
  line.set_token_id(entry.caller->token_id());
  line.set_by_link(entry.caller->is_by_link());
  line.set_tenant(entry.caller->rights().tenant);
  line.set_address(entry.caller.address);
  line.set_sheet(entry.sheet);
  line.set_request_id(entry.request_id);
  const std::lock_guard lock(mutex_);
  if (!outcome.ok() && !refusals_.take(1.0, clock_.now())) {
    ++left_out_;
    return;
  }
  const std::int64_t unix_us = clock_.unix_us();
  line.mutable_time()->set_seconds(unix_us / kMicroseconds);
  line.mutable_time()->set_nanos(static_cast<std::int32_t>(1000 * (unix_us % kMicroseconds)));
  line.set_left_out(left_out_);
  left_out_ = append_(wire::to_json(line) + "\n") ? 0 : left_out_ + 1;
}

}  // namespace kerf::api
