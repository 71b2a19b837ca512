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
#include "server/service/stream/measuring_time.h"
#include "server/service/stream/reader.h"
#include "server/service/stream/subscriber.h"

namespace kerf::stream {

// Counts the frames of several channels together, for metrics.
struct FrameCounters {
  std::atomic<std::int64_t> encoded{0};  // Keyframes and deltas; one frame shared by several subscribers counts once.
  std::atomic<std::int64_t> sent{0};     // Frames given to subscribers.
};

// Publishes the newest snapshot of one sheet to its readers: subscribers receive frames, other readers make pictures.
// The sheet's strand publishes. Threads of transports take the part of the newest snapshot that their own subscriber
// needs. Older snapshots are dropped and never sent. The first subscriber that takes a frame of a snapshot has it
// quantised and encoded; other subscribers share the bytes. Without subscribers nothing is encoded. Thread-safe;
// publish() waits for no encoding.
class Channel : public sheet::SnapshotSink, public std::enable_shared_from_this<Channel> {
 public:
  // `max_subscribers`: limit on readers of any kind. `instance`: identifies this start of the server and is part of the
  // epoch. `counters`: counts frames together with those of other channels; may be null. `now`: see MeasuringTime.
  explicit Channel(std::int32_t max_subscribers, std::string instance = {},
                   std::shared_ptr<FrameCounters> counters = nullptr, std::function<Nanoseconds()> now = nullptr)
      : max_subscribers_(max_subscribers),
        instance_(std::move(instance)),
        shared_counters_(std::move(counters)),
        measuring_(std::move(now)) {}

  // Adds a subscriber. `ready` is called, with no lock held, whenever next() may have something. That is after a
  // snapshot that the subscriber can take, an acknowledgement that opens its window, or the end. kResourceExhausted
  // TOO_MANY_SUBSCRIBERS; kUnavailable CHANNEL_ENDED.
  Result<std::shared_ptr<Subscriber>> subscribe(const SubscriberOptions& options, std::function<void()> ready);

  // Calls wake() and end() of `reader` from now on. Errors of subscribe().
  Status admit(const std::shared_ptr<Reader>& reader, bool wants_strains);
  // Sets whether an admitted reader needs snapshots. A paused reader needs none. When it resumes, the caller must have
  // the newest snapshot published again.
  void want_snapshots(const Reader& reader, bool wants);
  // Sets whether an admitted reader needs strains in the next snapshots.
  void want_strains(const Reader& reader, bool wants);
  // Removes a reader; does nothing if it is not admitted.
  void leave(const Reader& reader);

  struct Newest {
    std::int64_t publication = 0;  // Number of calls of publish() so far.
    // Number of publications that changed the look of the sheet. It stays the same if only the run state is new.
    std::int64_t revision = 0;
    std::shared_ptr<const sheet::Snapshot> snapshot;  // null before the first publication
  };
  [[nodiscard]] Newest newest() const;
  // Returns the number of calls of publish() so far.
  [[nodiscard]] std::int64_t newest_publication() const { return newest_publication_.load(); }

  [[nodiscard]] bool wants_snapshot() const override { return num_wanting_snapshots_.load() > 0; }
  [[nodiscard]] bool wants_strains() const override { return num_wanting_strains_.load() > 0; }
  [[nodiscard]] std::int32_t num_viewers() const override { return num_subscribers(); }
  // Has readers measure the sheet, as many as MeasuringTime allows; the others come first the next time.
  void measure(const sheet::Sheet& sheet, sheet::Snapshot& snapshot) override;
  void publish(std::shared_ptr<const sheet::Snapshot> snapshot) override;
  void ended(sheet::SinkEnd reason) override;

  [[nodiscard]] std::int32_t num_subscribers() const { return num_subscribers_.load(); }
  [[nodiscard]] bool has_ended() const;
  [[nodiscard]] EncodeCounters counters() const;

 private:
  friend class Subscriber;
  struct Entry {
    const Reader* reader = nullptr;  // Valid until the reader has left.
    std::weak_ptr<Reader> handle;
    bool wants_snapshots = true;
    bool wants_strains = false;
  };
  using Readers = std::vector<Entry>;

  // Returns kerf.v1.Frame.epoch of snapshots with this RunStats::sheet_serial.
  [[nodiscard]] std::string epoch_of(std::uint64_t sheet_serial) const;
  // Returns the serial of the newest snapshot if this is its epoch. A snapshot must have been published.
  [[nodiscard]] std::optional<std::uint64_t> serial_of(const std::string& epoch) const;
  // Returns the parts of the newest snapshot that a subscriber needs after the frame described by `viewed`. A snapshot
  // must have been published. `reader`: number of a subscriber that needs measured values. Nothing is returned if the
  // snapshot lacks them.
  std::optional<FramePick> pick(const Viewed& viewed, std::optional<std::uint64_t> reader);
  // Returns the time at which a snapshot with more values can be had by publishing the newest one again. Returns
  // nothing if a tick will bring one, because the sheet runs.
  [[nodiscard]] std::optional<Nanoseconds> next_values_at() const;
  void change(const Reader& reader, const std::function<void(Entry&)>& change);
  void replace_readers(std::shared_ptr<const Readers> readers);  // mutex_ held

  const std::int32_t max_subscribers_;
  const std::string instance_;
  const std::shared_ptr<FrameCounters> shared_counters_;
  std::atomic<std::int32_t> num_subscribers_{0};
  std::atomic<std::int32_t> num_wanting_snapshots_{0};
  std::atomic<std::int32_t> num_wanting_strains_{0};
  std::atomic<std::int64_t> newest_publication_{0};
  MeasuringTime measuring_;         // Used by the sheet's strand, except for rests_until().
  std::size_t first_measured_ = 0;  // Place of the reader that comes first in measure(); used by the sheet's strand.

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
