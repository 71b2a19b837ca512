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
#include "server/service/stream/reader.h"
#include "server/service/wire/frame_encoder.h"

namespace kerf::stream {

class Channel;

struct SubscriberOptions {
  FlowOptions flow;
  wire::Encoding encoding = wire::Encoding::kCompact;
  bool strains = false;                // frames have strains, from the next snapshot on
  std::string epoch = {};              // of what the viewer has from an earlier stream; empty: nothing
  std::int32_t topology_version = -1;  // likewise
};

// One stream of frames. A frame is given only while its FlowControl allows, and it is always the sheet's newest: a slow
// reader skips, never lags. The stream is taken as reliable and ordered: a frame given by next() is the base of later
// deltas. Thread-safe.
class Subscriber : public Reader {
 public:
  // Made by Channel::subscribe().
  Subscriber(std::shared_ptr<Channel> channel, const SubscriberOptions& options, std::function<void()> ready);
  ~Subscriber() override;  // leave()
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  struct Next {
    std::optional<Message> message;      // to be sent
    std::optional<Nanoseconds> wake_at;  // without a message: call next() again then, unless `ready` comes first
  };
  Next next(Nanoseconds now);

  // As FlowControl::acknowledge().
  Status acknowledge(std::int64_t sequence, Nanoseconds now = Nanoseconds(0), Nanoseconds held = Nanoseconds(0));

  // As FlowControl::set_pace(). True: a pause is over, and the next frame is that of a publication yet to come, which
  // is to be asked for: while all readers pause the channel gets none.
  [[nodiscard]] bool set_pace(double max_rate_hz, bool paused, Nanoseconds now);
  [[nodiscard]] const std::shared_ptr<Channel>& channel() const { return channel_; }

  [[nodiscard]] std::int32_t window() const;
  // next() has given an Ended message; nothing follows.
  [[nodiscard]] bool ended() const;

  // No more frames; `ready` is not called any more, though a call may still be under way. Idempotent.
  void leave() override;

  // Calls `ready` if next() waits for a publication. Takes no lock, because another thread may be encoding in next().
  void wake() override;
  void end(wire::EndReason reason) override;

 private:
  Next end_now(wire::EndReason reason);  // mutex_ held
  Message take(Nanoseconds now);         // mutex_ held

  const std::shared_ptr<Channel> channel_;
  const SubscriberOptions options_;
  const std::function<void()> ready_;

  // Lock order: mutex_, then the channel's.
  mutable std::mutex mutex_;
  FlowControl flow_;
  bool paused_ = false;
  std::int64_t stale_through_ = 0;  // publications that are older than the end of a pause
  std::int64_t last_tick_ = 0;
  Viewed viewed_;
  std::optional<wire::EndReason> end_;  // to be told
  bool ended_ = false;

  std::atomic<bool> wants_frame_{true};  // next() found nothing newer, and would have sent it
  std::atomic<bool> left_{false};
};

}  // namespace kerf::stream
