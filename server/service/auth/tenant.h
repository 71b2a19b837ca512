#pragma once

#include <cstdint>
#include <string>

namespace kerf::auth {

// Limits on what the sheets and the callers of a tenant take together. 0: no limit.
struct TenantLimits {
  std::int32_t max_sheets = 32;
  std::int64_t max_vertices = 2'000'000;                   // Vertices of all its sheets.
  std::int64_t max_state_bytes = std::int64_t{128} << 20;  // Bytes of the saved states of all its sheets.
  double max_workers = 1.0;            // Workers that its running sheets need, see host::WorkerNeed.
  std::int32_t max_streams = 64;       // Streams of frames that its callers have open.
  std::int32_t max_image_streams = 4;  // Streams of pictures that its callers have open.
  double max_cuts_per_s = 20.0;        // Calls that cut, undo or redo; twice as many at once.

  bool operator==(const TenantLimits&) const = default;
};

// A group of tokens with limits of its own. Its sheets are those whose ids begin with its name and a hyphen.
struct Tenant {
  std::string name;  // [a-z][a-z0-9]{0,15}
  TenantLimits limits;
};

}  // namespace kerf::auth
