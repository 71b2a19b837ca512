#include "server/service/host/tenants.h"

#include <cstdio>

namespace kerf::host {
namespace {

// Returns a number with at most two digits after the point.
std::string in_text(double number) {
  char text[32] = {};
  std::snprintf(text, sizeof text, "%.2f", number);
  std::string shortened = text;
  shortened.erase(shortened.find_last_not_of('0') + 1);
  if (shortened.ends_with('.')) shortened.pop_back();
  return shortened;
}

// `setting`: name of the limit in the token file.
Error beyond(const char* reason, const std::string& tenant, const std::string& limit, const std::string& remedy,
             const char* setting) {
  return resource_exhausted(reason,
                            "the tenant \"" + tenant + "\" may have " + limit + "; " + remedy +
                                ", or ask the operator for more (" + setting + "= in the token file)",
                            "tenant:" + tenant);
}

}  // namespace

std::string tenant_of(std::string_view sheet_id) {
  const std::size_t hyphen = sheet_id.find('-');
  return hyphen == std::string_view::npos ? std::string() : std::string(sheet_id.substr(0, hyphen));
}

Status check_new_sheet(const std::string& tenant, const TenantLimits& limits, const TenantUse& use,
                       std::int64_t vertices, double workers) {
  if (limits.max_sheets > 0 && use.sheets >= limits.max_sheets) {
    return beyond("TENANT_SHEETS", tenant, std::to_string(limits.max_sheets) + " sheets, and has them", "delete one",
                  "sheets");
  }
  KERF_TRY(check_need(tenant, limits, use, workers));
  return check_vertices(tenant, limits, use.vertices + vertices);
}

Status check_need(const std::string& tenant, const TenantLimits& limits, const TenantUse& use, double workers) {
  if (limits.max_workers == 0.0 || workers <= 0.0 || use.workers + workers <= limits.max_workers) return Nothing{};
  return beyond("TENANT_LOAD", tenant,
                in_text(limits.max_workers) + " workers busy, and its running sheets need " + in_text(use.workers) +
                    " while this one needs " + in_text(workers),
                "pause a sheet, or make this one paused", "workers");
}

Status check_vertices(const std::string& tenant, const TenantLimits& limits, std::int64_t vertices) {
  if (limits.max_vertices == 0 || vertices <= limits.max_vertices) return Nothing{};
  return beyond(
      "TENANT_VERTICES", tenant,
      std::to_string(limits.max_vertices) + " vertices in all sheets, and would have " + std::to_string(vertices),
      "delete a sheet, or make it coarser", "vertices");
}

Status check_state_bytes(const std::string& tenant, const TenantLimits& limits, std::int64_t bytes) {
  if (limits.max_state_bytes == 0 || bytes <= limits.max_state_bytes) return Nothing{};
  return beyond(
      "TENANT_STATES", tenant,
      std::to_string(limits.max_state_bytes) + " bytes of saved states, and would have " + std::to_string(bytes),
      "delete a saved state", "state-mib");
}

}  // namespace kerf::host
