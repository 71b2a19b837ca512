#include "server/service/api/watch_options.h"

#include <cstddef>
#include <string>

#include "kerf/v1/stream.pb.h"
#include "server/service/api/flow_request.h"

namespace kerf::api {
namespace {

constexpr double kSubscriptionRateHz = 1.0;
constexpr double kMaxSubscriptionRateHz = 10.0;
constexpr std::size_t kMaxEpochBytes = 64;

Result<wire::Encoding> decode_encoding(const v1::WatchStart& start) {
  switch (start.encoding()) {
    case v1::ENCODING_UNSPECIFIED:
    case v1::COMPACT:
      return wire::Encoding::kCompact;
    case v1::RAW:
      return wire::Encoding::kRaw;
    default:
      return invalid_argument("OUT_OF_RANGE",
                              "start.encoding is " + std::to_string(start.encoding()) +
                                  "; must be COMPACT (1) or RAW (2), or 0 for COMPACT",
                              "start.encoding");
  }
}

}  // namespace

Result<stream::SubscriberOptions> decode_options(const v1::WatchStart& start, const Limits& limits) {
  KERF_TRY_ASSIGN(const stream::FlowOptions flow, decode_flow(start.window(), start.max_rate_hz(), limits));
  stream::SubscriberOptions options;
  options.flow = flow;
  KERF_TRY_ASSIGN(options.encoding, decode_encoding(start));
  if (start.epoch().size() > kMaxEpochBytes) {
    return invalid_argument("OUT_OF_RANGE",
                            "start.epoch has " + std::to_string(start.epoch().size()) +
                                " bytes; it must be that of an earlier stream's first frame, or empty",
                            "start.epoch");
  }
  options.epoch = start.epoch();
  options.topology_version = start.topology_version();
  options.strains = start.strains();
  return options;
}

Result<stream::SubscriberOptions> decode_options(const v1::SubscribeRequest& request, const Limits& limits) {
  stream::SubscriberOptions options;
  options.flow = flow_within(limits);
  KERF_TRY_ASSIGN(const double rate,
                  decode_rate(request.max_rate_hz(), kMaxSubscriptionRateHz, "one a second", "max_rate_hz"));
  options.flow.max_rate_hz = rate == 0.0 ? kSubscriptionRateHz : rate;
  options.encoding = wire::Encoding::kRaw;
  options.flow.acknowledges = false;
  if (request.max_frames() < 0) {
    return invalid_argument("OUT_OF_RANGE",
                            "max_frames is " + std::to_string(request.max_frames()) + "; must be 0 (no end) or more",
                            "max_frames");
  }
  return options;
}

}  // namespace kerf::api
