#pragma once

#include "server/base/result.h"

namespace kerf::host {

inline Error host_stopping() {
  return unavailable("HOST_STOPPING", "the server is stopping");
}

}  // namespace kerf::host
