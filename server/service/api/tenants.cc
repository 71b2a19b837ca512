#include "server/service/api/tenants.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace kerf::api {
namespace {

std::string in_text(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

}  // namespace

void Tenants::set(const std::vector<auth::Tenant>& tenants) {
  const std::lock_guard lock(mutex_);
  std::map<std::string, Known> before = std::exchange(tenants_, {});
  for (const auth::Tenant& tenant : tenants) {
    const auto old = before.find(tenant.name);
    Known known = old == before.end() ? Known() : std::move(old->second);
    const double rate = tenant.limits.max_cuts_per_s;
    if (old == before.end() || known.limits.max_cuts_per_s != rate) {
      known.cuts =
          rate > 0.0 ? std::optional(TokenBucket(rate, std::max(2.0 * rate, 1.0), clock_.now())) : std::nullopt;
    }
    known.limits = tenant.limits;
    tenants_.emplace(tenant.name, std::move(known));
  }
}

std::optional<host::TenantLimits> Tenants::sheet_limits(const std::string& tenant) const {
  const std::lock_guard lock(mutex_);
  const auto known = tenants_.find(tenant);
  if (known == tenants_.end()) return std::nullopt;
  const auth::TenantLimits& limits = known->second.limits;
  return host::TenantLimits{limits.max_sheets, limits.max_vertices, limits.max_state_bytes, limits.max_workers};
}

Status Tenants::take_cut(const std::string& tenant) {
  const std::lock_guard lock(mutex_);
  const auto known = tenants_.find(tenant);
  if (known == tenants_.end() || !known->second.cuts || known->second.cuts->take(1.0, clock_.now())) return Nothing{};
  return resource_exhausted("TENANT_CUTS",
                            "the tenant \"" + tenant + "\" may cut " + in_text(known->second.limits.max_cuts_per_s) +
                                " times a second, in all its sheets; send fewer calls, or many cuts in one CreateCuts",
                            "tenant:" + tenant);
}

Result<std::shared_ptr<const void>> Tenants::open_stream(const std::string& tenant, Stream kind) {
  const std::lock_guard lock(mutex_);
  const auto known = tenants_.find(tenant);
  if (known == tenants_.end()) return std::shared_ptr<const void>();
  const bool is_frames = kind == Stream::kFrames;
  const auth::TenantLimits& limits = known->second.limits;
  const std::int32_t limit = is_frames ? limits.max_streams : limits.max_image_streams;
  const std::shared_ptr<Counts> open = known->second.open;
  std::atomic<std::int32_t>& count = is_frames ? open->streams : open->image_streams;
  if (limit > 0 && count >= limit) {
    return resource_exhausted(is_frames ? "TENANT_STREAMS" : "TENANT_IMAGE_STREAMS",
                              "the tenant \"" + tenant + "\" may have " + std::to_string(limit) +
                                  (is_frames ? " streams" : " streams of pictures") + " open, and has them; close one",
                              "tenant:" + tenant);
  }
  ++count;
  return std::shared_ptr<const void>(&count, [open, &count](const void* /*counted*/) { --count; });
}

std::optional<Tenants::Use> Tenants::use_of(const std::string& tenant) const {
  const std::lock_guard lock(mutex_);
  const auto known = tenants_.find(tenant);
  if (known == tenants_.end()) return std::nullopt;
  return Use{known->second.limits, known->second.open->streams, known->second.open->image_streams};
}

}  // namespace kerf::api
