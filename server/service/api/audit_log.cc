#include "server/service/api/audit_log.h"

#include <utility>

#include "kerf/v1/access_service.pb.h"
#include "server/service/wire/json.h"

namespace kerf::api {
namespace {

constexpr double kSecondsOfMinute = 60.0;
constexpr std::int64_t kMicroseconds = 1'000'000;

// Cuts a text between two characters of UTF-8.
std::string shortened(const std::string& text) {
  if (text.size() <= AuditLog::kLongestName) return text;
  std::size_t end = AuditLog::kLongestName;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "...";
}

}  // namespace

void AuditLog::add(const Entry& entry, const Status& outcome) {
  v1::AuditEntry line;
  line.set_call(entry.call);
  line.set_outcome(outcome.ok() ? "OK" : outcome.error().reason);
  line.set_token_id(entry.caller->token_id());
  line.set_by_link(entry.caller->is_by_link());
  line.set_tenant(entry.caller->rights().tenant);
  line.set_address(entry.caller.address);
  line.set_sheet(shortened(entry.sheet));
  line.set_request_id(shortened(entry.request_id));
  const std::lock_guard lock(mutex_);
  if (!outcome.ok()) {
    constexpr double kPerSecond = kMaxRefusals / kSecondsOfMinute;
    TokenBucket& bucket = refusals_.try_emplace(line.token_id(), kPerSecond, kMaxRefusals, clock_.now()).first->second;
    if (!bucket.take(1.0, clock_.now())) {
      ++left_out_;
      return;
    }
  }
  const std::int64_t unix_us = clock_.unix_us();
  line.mutable_time()->set_seconds(unix_us / kMicroseconds);
  line.mutable_time()->set_nanos(static_cast<std::int32_t>(1000 * (unix_us % kMicroseconds)));
  line.set_left_out(left_out_);
  left_out_ = append_(wire::to_json(line) + "\n") ? 0 : left_out_ + 1;
}

}  // namespace kerf::api
