#pragma once

#include <memory>

#include "server/service/api/core.h"
#include "server/service/api/watch_session.h"
#include "server/service/auth/grant.h"

namespace kerf::v1 {
class SubscribeRequest;
}  // namespace kerf::v1

namespace kerf::api {

// `caller`: who watches. If it is an error, the stream has failed with it.
std::shared_ptr<WatchSession> make_watch_session(const std::shared_ptr<ApiCore>& core,
                                                 const Result<auth::Caller>& caller);

// Returns a started session of StreamService.Subscribe, which takes no requests.
std::shared_ptr<WatchSession> make_subscription(const std::shared_ptr<ApiCore>& core,
                                                const Result<auth::Caller>& caller,
                                                const v1::SubscribeRequest& request);

}  // namespace kerf::api
