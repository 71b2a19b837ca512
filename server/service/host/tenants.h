#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::host {

// Limits on what the sheets of a tenant take together. 0: no limit.
struct TenantLimits {
  std::int32_t max_sheets = 0;
  std::int64_t max_vertices = 0;
  std::int64_t max_state_bytes = 0;  // of saved states
  double max_workers = 0.0;          // Workers that running sheets need, see WorkerNeed.
};

// Says what the sheets of a tenant take now, those being built included.
struct TenantUse {
  std::int32_t sheets = 0;
  std::int64_t vertices = 0;
  std::int64_t state_bytes = 0;
  double workers = 0.0;
};

// Returns the limits of the tenant of a name; nothing if there is no such tenant. Thread-safe.
using FindTenant = std::function<std::optional<TenantLimits>(const std::string& tenant)>;

// Returns the name of the tenant that a sheet would belong to: what comes before the first hyphen of its id; empty:
// none.
std::string tenant_of(std::string_view sheet_id);

// Checks whether a tenant that uses `use` may have one more sheet. `vertices`, `workers`: what that takes.
// kResourceExhausted TENANT_SHEETS, TENANT_VERTICES or TENANT_LOAD.
Status check_new_sheet(const std::string& tenant, const TenantLimits& limits, const TenantUse& use,
                       std::int64_t vertices, double workers);
// Checks whether its running sheets may need this many workers more. kResourceExhausted TENANT_LOAD.
Status check_need(const std::string& tenant, const TenantLimits& limits, const TenantUse& use, double workers);
// Checks whether it may have this many vertices. kResourceExhausted TENANT_VERTICES.
Status check_vertices(const std::string& tenant, const TenantLimits& limits, std::int64_t vertices);
// Checks whether its saved states may take this many bytes. kResourceExhausted TENANT_STATES.
Status check_state_bytes(const std::string& tenant, const TenantLimits& limits, std::int64_t bytes);

}  // namespace kerf::host
