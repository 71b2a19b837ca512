#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/base/result.h"
#include "server/stream/frame_history.h"
#include "server/stream/message.h"
#include "server/stream/window_control.h"
#include "server/wire/frame_encoder.h"

namespace kerf::stream {

class Channel;

struct SubscriberOptions {
  std::int32_t window = 2;                             // frames in flight, 1..8; 0: see WindowControl
  double max_rate_hz = 0.0;                            // frames a second, >= 0; 0: every tick
  std::size_t max_unacknowledged_bytes = 4 << 20;      // no frame is sent while this much or more is in flight
  Nanoseconds ack_timeout = std::chrono::seconds(10);  // for the oldest frame in flight
  wire::Encoding encoding = wire::Encoding::kCompact;
  bool strains = false;                // frames have strains, from the next snapshot on
  bool acknowledges = true;            // false: frames count as acknowledged once they are sent
  std::string epoch = {};              // of what the viewer has from an earlier stream; empty: nothing
  std::int32_t topology_version = -1;  // likewise
};

// One stream of frames. A frame is given only while fewer than `window` frames and max_unacknowledged_bytes are
// unacknowledged and max_rate_hz allows, and it is always the sheet's newest: a slow reader skips, never lags. The
// stream is taken as reliable and ordered: a frame given by next() is the base of later deltas. Thread-safe.
class Subscriber {
 public:
  // Made by Channel::subscribe().
  Subscriber(std::shared_ptr<Channel> channel, const SubscriberOptions& options, std::function<void()> ready);
  ~Subscriber();  // leave()
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  struct Next {
    std::optional<Message> message;      // to be sent
    std::optional<Nanoseconds> wake_at;  // without a message: call next() again then, unless `ready` comes first
  };
  Next next(Nanoseconds now);

  // All frames up to `sequence` have arrived, the last of them `held` ago (0: not told) as seen at `now`. One that is
  // acknowledged already is no error.
  // kInvalidArgument ACK_OUT_OF_RANGE, field "ack.sequence": outside 1..last sent; field "ack.held_us": below 0.
  Status acknowledge(std::int64_t sequence, Nanoseconds now = Nanoseconds(0), Nanoseconds held = Nanoseconds(0));

  // From now on. max_rate_hz as in the options; while paused there are no frames, and no acknowledgement is owed.
  void set_pace(double max_rate_hz, bool paused, Nanoseconds now);

  [[nodiscard]] std::int32_t window() const;
  [[nodiscard]] bool wants_strains() const { return options_.strains; }

  // next() has given an Ended message; nothing follows.
  [[nodiscard]] bool ended() const;

  // No more frames; `ready` is not called any more, though a call may still be under way. Idempotent.
  void leave();

 private:
  friend class Channel;
  struct InFlight {
    std::int64_t sequence = 0;
    std::size_t bytes = 0;
    Nanoseconds sent_at{0};
    bool alone = false;  // nothing else was under way
  };

  // By the channel after a publication: calls `ready` if next() waits for one. Takes no lock, because another thread
  // may be encoding in next().
  void wake();
  void end(wire::EndReason reason);

  [[nodiscard]] bool window_open() const;          // mutex_ held
  [[nodiscard]] Nanoseconds ack_deadline() const;  // mutex_ held; only with a frame in flight
  Next end_now(wire::EndReason reason);            // mutex_ held
  Message take(Nanoseconds now);                   // mutex_ held
  // Ones of equal rates end at the same times, so that all viewers of a rate are at the same frame and share what is
  // encoded for it.
  [[nodiscard]] Nanoseconds next_slot(Nanoseconds now) const;     // mutex_ held
  void note_interval(std::int64_t publication, Nanoseconds now);  // mutex_ held
  // Removes what is acknowledged; the last of it, if any.
  std::optional<InFlight> settle(std::int64_t sequence);  // mutex_ held

  const std::shared_ptr<Channel> channel_;
  const SubscriberOptions options_;
  const std::function<void()> ready_;

  // Lock order: mutex_, then the channel's.
  mutable std::mutex mutex_;
  std::deque<InFlight> in_flight_;
  std::size_t bytes_in_flight_ = 0;
  std::int64_t last_sequence_ = 0;
  std::int64_t last_tick_ = 0;
  Viewed viewed_;
  WindowControl window_;
  double max_rate_hz_;
  bool paused_ = false;
  Nanoseconds next_allowed_ = Nanoseconds::min();  // by max_rate_hz_
  Nanoseconds last_taken_at_{0};
  double tick_interval_s_ = 0.0;        // between publications, smoothed; 0: not known yet
  std::optional<wire::EndReason> end_;  // to be told
  bool ended_ = false;

  std::atomic<bool> wants_frame_{true};  // next() found nothing newer, and would have sent it
  std::atomic<bool> left_{false};
};

}  // namespace kerf::stream
