#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "server/service/api/api.h"
#include "server/service/stream/flow_control.h"

namespace kerf::v1 {
class WatchAck;
}  // namespace kerf::v1

// What clients ask of the flow of a stream, whatever is streamed. Errors are kInvalidArgument OUT_OF_RANGE with the
// field.
namespace kerf::api {

inline constexpr double kMaxRateHz = 1000.0;

// 0, or 0.001 to `max_hz`. `meaning_of_0`: for the error.
Result<double> decode_rate(double rate_hz, double max_hz, const char* meaning_of_0, const std::string& field);

// Within the limits of one stream, with no rate.
stream::FlowOptions flow_within(const Limits& limits);

// A start's window and max_rate_hz.
Result<stream::FlowOptions> decode_flow(std::int32_t window, double max_rate_hz, const Limits& limits);

// How long the reader held what it acknowledges.
std::chrono::microseconds held_of(const v1::WatchAck& ack);

// Of a message in a stream's protocol: it must be of some kind, and the first, and only the first, a start. `kinds`:
// for the error, "start, ack or pace".
Status check_turn(bool has_kind, bool is_start, bool started, const char* kinds);

}  // namespace kerf::api
