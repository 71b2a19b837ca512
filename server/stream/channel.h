#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/base/result.h"
#include "server/sheet/snapshot.h"
#include "server/stream/frame_history.h"
#include "server/stream/subscriber.h"

namespace kerf::stream {

// The frames of one sheet, for everyone who watches it. The sheet's strand publishes; threads of transports take, each
// for its own subscriber, what that one needs of the newest snapshot. Older snapshots are let go: nobody is sent one
// when there is a newer. Quantising and encoding happen when the first subscriber takes a frame, once for all of them,
// and not at all without subscribers. Thread-safe; publish() waits for no encoding.
class Channel : public sheet::SnapshotSink, public std::enable_shared_from_this<Channel> {
 public:
  // `instance`: of this start of the server; part of the epoch.
  explicit Channel(std::int32_t max_subscribers, std::string instance = {})
      : max_subscribers_(max_subscribers), instance_(std::move(instance)) {}

  // `ready` is called, with no lock held, when the subscriber's next() may have something: after a snapshot that it can
  // take, an acknowledgement that opens its window, or the end.
  // kResourceExhausted TOO_MANY_SUBSCRIBERS; kUnavailable CHANNEL_ENDED.
  Result<std::shared_ptr<Subscriber>> subscribe(const SubscriberOptions& options, std::function<void()> ready);

  [[nodiscard]] bool wants_snapshot() const override { return num_subscribers_.load() > 0; }
  [[nodiscard]] bool wants_strains() const override { return num_wanting_strains_.load() > 0; }
  void publish(std::shared_ptr<const sheet::Snapshot> snapshot) override;
  void ended(sheet::SinkEnd reason) override;

  [[nodiscard]] std::int32_t num_subscribers() const { return num_subscribers_.load(); }
  [[nodiscard]] bool has_ended() const;
  [[nodiscard]] EncodeCounters counters() const;

 private:
  friend class Subscriber;
  struct Entry {
    const Subscriber* subscriber = nullptr;  // valid until it has left
    std::weak_ptr<Subscriber> handle;
  };
  using Subscribers = std::vector<Entry>;

  // Counts publications from 1; 0 before the first.
  [[nodiscard]] std::int64_t newest_publication() const { return newest_publication_.load(); }
  // kerf.v1.Frame.epoch of the newest snapshot; one must have been published.
  [[nodiscard]] std::string epoch() const;
  // What a subscriber in this state needs of the newest snapshot; one must have been published.
  FramePick pick(const Viewed& viewed);
  void leave(const Subscriber& subscriber);
  void wake_all();

  const std::int32_t max_subscribers_;
  const std::string instance_;
  std::atomic<std::int32_t> num_subscribers_{0};
  std::atomic<std::int32_t> num_wanting_strains_{0};
  std::atomic<std::int64_t> newest_publication_{0};

  // Lock order: frames_mutex_, then mutex_. Neither is held while a callback runs.
  mutable std::mutex frames_mutex_;
  FrameHistory history_;  // guarded by frames_mutex_

  mutable std::mutex mutex_;
  std::shared_ptr<const sheet::Snapshot> newest_;   // guarded by mutex_
  std::shared_ptr<const Subscribers> subscribers_;  // guarded by mutex_; replaced, never changed
  std::optional<sheet::SinkEnd> end_;               // guarded by mutex_
};

}  // namespace kerf::stream
