#include "server/service/api/flow_request.h"

#include <algorithm>
#include <sstream>

#include "kerf/v1/stream.pb.h"

namespace kerf::api {
namespace {

constexpr double kMinRateHz = 1.0e-3;               // A frame in a quarter of an hour; far below it, periods overflow.
constexpr std::int64_t kMaxHeldUs = 3'600'000'000;  // An hour; far above it, nanoseconds overflow.

}  // namespace

Result<double> decode_rate(double rate_hz, double max_hz, const char* meaning_of_0, const std::string& field) {
  if (rate_hz == 0.0 || (rate_hz >= kMinRateHz && rate_hz <= max_hz)) return rate_hz;  // Refuses NaN.
  std::ostringstream message;
  message << field << " is " << rate_hz << "; must be 0.001 to " << max_hz << ", or 0 for " << meaning_of_0;
  return invalid_argument("OUT_OF_RANGE", message.str(), field);
}

stream::FlowOptions flow_within(const Limits& limits) {
  stream::FlowOptions flow;
  flow.max_unacknowledged_bytes = static_cast<std::size_t>(limits.max_unsent_bytes_per_subscriber);
  flow.ack_timeout = limits.watch_ack_timeout;
  return flow;
}

Result<stream::FlowOptions> decode_flow(std::int32_t window, double max_rate_hz, const Limits& limits) {
  stream::FlowOptions flow = flow_within(limits);
  if (window < 0 || window > stream::kMaxWindow) {
    return invalid_argument("OUT_OF_RANGE",
                            "start.window is " + std::to_string(window) + "; must be 1 to 8, or 0 for an adaptive one",
                            "start.window");
  }
  flow.window = window;
  KERF_TRY_ASSIGN(flow.max_rate_hz, decode_rate(max_rate_hz, kMaxRateHz, "every tick", "start.max_rate_hz"));
  return flow;
}

std::chrono::microseconds held_of(const v1::WatchAck& ack) {
  return std::chrono::microseconds(std::min(ack.held_us(), kMaxHeldUs));
}

Status check_turn(bool has_kind, bool is_start, bool started, const char* kinds) {
  if (!has_kind) return invalid_argument("CHOICE_MISSING", std::string("kind must be one of ") + kinds, "kind");
  if (is_start != started) return Nothing{};
  return is_start ? invalid_argument("STARTED_TWICE", "this stream has already started; open another", "start")
                  : invalid_argument("START_MISSING", "the first message of a stream must be start", "start");
}

}  // namespace kerf::api
