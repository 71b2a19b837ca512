#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/base/token_bucket.h"
#include "server/service/auth/tenant.h"
#include "server/service/host/clock.h"
#include "server/service/host/tenants.h"

namespace kerf::api {

// Holds the tenants of a server, and counts what their callers do. Thread-safe.
class Tenants {
 public:
  // `clock` must outlive this.
  explicit Tenants(host::Clock& clock) : clock_(clock) {}
  Tenants(const Tenants&) = delete;
  Tenants& operator=(const Tenants&) = delete;

  // Takes these tenants in place of those before. What their callers have open still counts.
  void set(const std::vector<auth::Tenant>& tenants);

  // Returns the limits of the sheets of a tenant; nothing if there is none of that name.
  [[nodiscard]] std::optional<host::TenantLimits> sheet_limits(const std::string& tenant) const;

  // Counts a call that cuts. kResourceExhausted TENANT_CUTS. `tenant` may be empty here and below: no limit.
  Status take_cut(const std::string& tenant);

  enum class Stream { kFrames, kPictures };
  // Counts an open stream until the result is destroyed. kResourceExhausted TENANT_STREAMS, TENANT_IMAGE_STREAMS.
  Result<std::shared_ptr<const void>> open_stream(const std::string& tenant, Stream kind);

  struct Use {
    auth::TenantLimits limits;
    std::int32_t streams = 0;
    std::int32_t image_streams = 0;
  };
  [[nodiscard]] std::optional<Use> use_of(const std::string& tenant) const;

 private:
  struct Counts {
    std::atomic<std::int32_t> streams = 0;  // grows with mutex_ held
    std::atomic<std::int32_t> image_streams = 0;
  };
  struct Known {
    auth::TenantLimits limits;
    std::optional<TokenBucket> cuts;  // none: no limit
    std::shared_ptr<Counts> open = std::make_shared<Counts>();
  };

  host::Clock& clock_;
  mutable std::mutex mutex_;
  std::map<std::string, Known> tenants_;  // by name; guarded by mutex_
};

}  // namespace kerf::api
