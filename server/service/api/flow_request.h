#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "server/service/api/api.h"
#include "server/service/stream/flow_control.h"

namespace kerf::v1 {
class WatchAck;
}  // namespace kerf::v1

// Decodes the flow control requests of clients for any kind of stream. Errors are kInvalidArgument OUT_OF_RANGE with
// the field.
namespace kerf::api {

inline constexpr double kMaxRateHz = 1000.0;

// Accepts 0, or 0.001 to `max_hz`. `meaning_of_0` is for the error message.
Result<double> decode_rate(double rate_hz, double max_hz, const char* meaning_of_0, const std::string& field);

// Returns options within the limits of one stream, without a rate.
stream::FlowOptions flow_within(const Limits& limits);

// Decodes the window and max_rate_hz of a start.
Result<stream::FlowOptions> decode_flow(std::int32_t window, double max_rate_hz, const Limits& limits);

// Returns how long the reader held the acknowledged frame.
std::chrono::microseconds held_of(const v1::WatchAck& ack);

// Checks the order of a stream's messages: each has a kind, and exactly the first is a start. `kinds` is for the error
// message, such as "start, ack or pace".
Status check_turn(bool has_kind, bool is_start, bool started, const char* kinds);

}  // namespace kerf::api
