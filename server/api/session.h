#pragma once

#include <memory>

#include "server/api/core.h"
#include "server/api/watch_session.h"

namespace kerf::api {

std::shared_ptr<WatchSession> make_watch_session(const std::shared_ptr<ApiCore>& core);

// For Api::stop(): streams that watch no sheet yet end with kUnavailable; the hub ends the others.
void refuse_unstarted_sessions(ApiCore& core);

}  // namespace kerf::api
