#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/base/result.h"
#include "server/service/stream/flow_control.h"
#include "server/service/stream/frame_history.h"
#include "server/service/stream/message.h"
#include "server/service/stream/meter.h"
#include "server/service/stream/reader.h"
#include "server/service/wire/frame_encoder.h"

namespace kerf::stream {

class Channel;

struct SubscriberOptions {
  FlowOptions flow;
  wire::Encoding encoding = wire::Encoding::kCompact;
  bool strains = false;    // Frames have strains, from the next snapshot on.
  std::string epoch = {};  // Epoch of the topology that the viewer kept from an earlier stream; empty: none.
  std::int32_t topology_version = -1;  // Version of that topology; -1: none.
  // Measures the sheet of each frame; null: frames have no values. No other stream may use it.
  std::shared_ptr<Meter> meter = nullptr;
};

// Makes the messages of one stream of frames. next() gives a frame only when FlowControl allows, always of the newest
// snapshot. Thus a slow reader skips frames, but never lags. The transport must be reliable and ordered, because every
// frame given by next() may be the base of the next delta. Thread-safe.
class Subscriber : public Reader {
 public:
  // Made by Channel::subscribe().
  Subscriber(std::shared_ptr<Channel> channel, const SubscriberOptions& options, std::function<void()> ready);
  ~Subscriber() override;  // leave()
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  struct Next {
    std::optional<Message> message;      // To be sent.
    std::optional<Nanoseconds> wake_at;  // Without a message: call next() again then, unless `ready` comes first.
    bool wants_snapshot = false;         // The newest snapshot must be published again, to be measured for this stream.
  };
  Next next(Nanoseconds now);

  // Calls FlowControl::acknowledge() and wakes the stream if the window has opened.
  Status acknowledge(std::int64_t sequence, Nanoseconds now = Nanoseconds(0), Nanoseconds held = Nanoseconds(0));

  // Calls FlowControl::set_frame_rate(). Returns true if a pause has ended. The next frame then shows a snapshot that
  // is still to be published. The caller must request it, because the channel gets no snapshots while all readers
  // pause.
  [[nodiscard]] bool set_frame_rate(double max_rate_hz, bool paused, Nanoseconds now);
  [[nodiscard]] const std::shared_ptr<Channel>& channel() const { return channel_; }

  [[nodiscard]] std::int32_t window() const;
  // True once next() has given an Ended message; nothing follows.
  [[nodiscard]] bool ended() const;

  // Ends the stream without a message. `ready` is not called any more, though a call may still be in progress.
  // Idempotent.
  void leave() override;

  // Calls `ready` if next() waits for a publication. Takes no lock, because another thread may be encoding in next().
  void wake() override;
  // Measures only while the next frame may be sent, so that skipped frames cost nothing.
  void measure(const sheet::Sheet& sheet, sheet::Snapshot& snapshot) override;
  void end(wire::EndReason reason) override;

 private:
  Next end_now(wire::EndReason reason);  // mutex_ held
  // Returns the frame of the newest snapshot; nothing if that was not measured for this stream. mutex_ held.
  std::optional<Message> take(Nanoseconds now);
  // Returns what to do until there is a snapshot that was measured. mutex_ held.
  Next wait_for_values(std::int64_t newest, const FlowControl::Permit& permit, Nanoseconds now);

  const std::shared_ptr<Channel> channel_;
  const SubscriberOptions options_;
  const std::uint64_t number_;  // Among all subscribers of this process.
  const std::function<void()> ready_;

  // Lock order: mutex_, then the channel's.
  mutable std::mutex mutex_;
  FlowControl flow_;
  bool paused_ = false;
  // Publications up to this number are not sent: the one before a pause ended, and older ones.
  std::int64_t stale_through_ = 0;
  std::int64_t last_tick_ = 0;    // Tick of the last frame.
  std::int64_t asked_after_ = 0;  // Publication after which next() asked for it to be published again.
  Viewed viewed_;
  std::optional<wire::EndReason> end_;  // Reason of the Ended message that is still to be sent.
  bool ended_ = false;                  // The Ended message was given.

  // next() could have sent a frame, but found no newer snapshot: wake() must call `ready`.
  std::atomic<bool> wants_frame_{true};
  std::atomic<bool> wants_values_{true};  // The next frame may be sent, and has not been taken.
  std::atomic<bool> left_{false};
};

}  // namespace kerf::stream
