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
#include "server/core/sheet/snapshot.h"
#include "server/service/stream/frame_history.h"
#include "server/service/stream/reader.h"
#include "server/service/stream/subscriber.h"

namespace kerf::stream {

// Of several channels together, for metrics.
struct FrameCounters {
  std::atomic<std::int64_t> encoded{0};  // keyframes and differences to an older frame; one for all who need the same
  std::atomic<std::int64_t> sent{0};     // given to subscribers
};

// The newest snapshot of one sheet, for everyone who watches it: subscribers, who are sent frames, and other readers,
// who make pictures of it. The sheet's strand publishes; threads of transports take, each for its own subscriber, what
// that one needs of the newest snapshot. Older snapshots are let go: nobody is sent one when there is a newer.
// Quantising and encoding happen when the first subscriber takes a frame, once for all of them, and not at all without
// subscribers. Thread-safe; publish() waits for no encoding.
class Channel : public sheet::SnapshotSink, public std::enable_shared_from_this<Channel> {
 public:
  // `max_subscribers`: readers of any kind. `instance`: of this start of the server; part of the epoch. `counters`:
  // where frames are counted together with those of other channels; may be null.
  explicit Channel(std::int32_t max_subscribers, std::string instance = {},
                   std::shared_ptr<FrameCounters> counters = nullptr)
      : max_subscribers_(max_subscribers), instance_(std::move(instance)), shared_counters_(std::move(counters)) {}

  // `ready` is called, with no lock held, when the subscriber's next() may have something: after a snapshot that it can
  // take, an acknowledgement that opens its window, or the end.
  // kResourceExhausted TOO_MANY_SUBSCRIBERS; kUnavailable CHANNEL_ENDED.
  Result<std::shared_ptr<Subscriber>> subscribe(const SubscriberOptions& options, std::function<void()> ready);

  // Wakes and ends `reader` from now on. Errors of subscribe().
  Status admit(const std::shared_ptr<Reader>& reader, bool wants_strains);
  // Whether there are to be snapshots, for a reader that was admitted: a paused one needs none, and must have the
  // newest published when it goes on.
  void want_snapshots(const Reader& reader, bool wants);
  // Whether the next snapshots are to have strains, for a reader that was admitted.
  void want_strains(const Reader& reader, bool wants);
  // Does nothing for a reader that is not here.
  void leave(const Reader& reader);

  struct Newest {
    std::int64_t publication = 0;  // counts them, from 1; 0: there was none
    std::int64_t revision =
        0;  // of what the sheet looks like: that of the publication before where only its run state is new
    std::shared_ptr<const sheet::Snapshot> snapshot;  // null before the first publication
  };
  [[nodiscard]] Newest newest() const;
  // Counts publications from 1; 0 before the first.
  [[nodiscard]] std::int64_t newest_publication() const { return newest_publication_.load(); }

  [[nodiscard]] bool wants_snapshot() const override { return num_wanting_snapshots_.load() > 0; }
  [[nodiscard]] bool wants_strains() const override { return num_wanting_strains_.load() > 0; }
  [[nodiscard]] std::int32_t num_viewers() const override { return num_subscribers(); }
  void publish(std::shared_ptr<const sheet::Snapshot> snapshot) override;
  void ended(sheet::SinkEnd reason) override;

  [[nodiscard]] std::int32_t num_subscribers() const { return num_subscribers_.load(); }
  [[nodiscard]] bool has_ended() const;
  [[nodiscard]] EncodeCounters counters() const;

 private:
  friend class Subscriber;
  struct Entry {
    const Reader* reader = nullptr;  // valid until it has left
    std::weak_ptr<Reader> handle;
    bool wants_snapshots = true;
    bool wants_strains = false;
  };
  using Readers = std::vector<Entry>;

  // kerf.v1.Frame.epoch of the newest snapshot; one must have been published.
  [[nodiscard]] std::string epoch() const;
  // What a subscriber in this state needs of the newest snapshot; one must have been published.
  FramePick pick(const Viewed& viewed);
  void change(const Reader& reader, const std::function<void(Entry&)>& change);
  void replace_readers(std::shared_ptr<const Readers> readers);  // mutex_ held

  const std::int32_t max_subscribers_;
  const std::string instance_;
  const std::shared_ptr<FrameCounters> shared_counters_;
  std::atomic<std::int32_t> num_subscribers_{0};
  std::atomic<std::int32_t> num_wanting_snapshots_{0};
  std::atomic<std::int32_t> num_wanting_strains_{0};
  std::atomic<std::int64_t> newest_publication_{0};

  // Lock order: frames_mutex_, then mutex_. Neither is held while a callback runs.
  mutable std::mutex frames_mutex_;
  FrameHistory history_;  // guarded by frames_mutex_

  mutable std::mutex mutex_;
  std::shared_ptr<const sheet::Snapshot> newest_;                         // guarded by mutex_
  std::int64_t revision_ = 0;                                             // of newest_; guarded by mutex_
  std::shared_ptr<const Readers> readers_ = std::make_shared<Readers>();  // guarded by mutex_; replaced, never changed
  std::optional<sheet::SinkEnd> end_;                                     // guarded by mutex_
};

}  // namespace kerf::stream
