#pragma once

#include "server/base/result.h"
#include "server/service/api/api.h"
#include "server/service/stream/subscriber.h"

namespace kerf::v1 {
class SubscribeRequest;
class WatchStart;
}  // namespace kerf::v1

namespace kerf::api {

// Decode the options of a stream of frames. Errors: kInvalidArgument OUT_OF_RANGE with the field.
Result<stream::SubscriberOptions> decode_options(const v1::WatchStart& start, const Limits& limits);
Result<stream::SubscriberOptions> decode_options(const v1::SubscribeRequest& request, const Limits& limits);

}  // namespace kerf::api
