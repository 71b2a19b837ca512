#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "render/renderer.h"
#include "server/service/host/clock.h"
#include "server/service/picture/background_worker.h"
#include "server/service/picture/picture.h"
#include "server/service/picture/video_track.h"
#include "server/service/stream/channel.h"
#include "server/service/stream/message.h"

namespace kerf::api {

// What was done so far, for metrics and for tests that nothing is done in vain or twice.
struct PictureCounters {
  std::atomic<std::int64_t> rendered{0};
  std::atomic<std::int64_t> encoded{0};
  std::atomic<std::int64_t> shared{0};   // given to a stream, and encoded for another one or for an earlier picture
  std::atomic<std::int64_t> sent{0};     // to streams
  std::atomic<std::int64_t> skipped{0};  // ticks that a stream was sent no picture of, between two of its pictures
};

// A finished picture of a stream.
struct FinishedPicture {
  std::int64_t publication = 0;                     // of the channel
  std::shared_ptr<const sheet::Snapshot> snapshot;  // that it shows
  render::Camera camera;                            // that it was drawn with
  double strain_end = 0.0;                          // of the scale of strains; 0: it has none
  int width = 0;                                    // pixels
  int height = 0;                                   // pixels
  bool key = true;                                  // can be decoded by itself
  stream::Bytes data;                               // never null
};

// What a stream wants of the next picture of a feed.
struct PictureOrder {
  StillFormat still;                  // where there is no video
  std::shared_ptr<VideoTrack> video;  // the stream's own; null: a still
  bool key = false;                   // a video frame that can be decoded by itself
  // Called once, on a thread of the studio and with no lock of it held; not at all once the studio has stopped.
  std::function<void(Result<FinishedPicture>)> done;
};

// Of one picture, in different formats: those made last. Whoever wants another has it encoded again.
inline constexpr std::size_t kMaxKeptStills = 4;

class PictureStudio;

// One view of one sheet, for all streams that look at it so. An order is filled with a picture of the newest tick as of
// when its turn has come. A picture of that tick that was drawn, or encoded in the same way, for anyone is used again;
// at most one is being drawn. Thread-safe.
class PictureFeed : public std::enable_shared_from_this<PictureFeed> {
 public:
  // Made by PictureStudio::feed(). The channel must have a snapshot before the first order.
  PictureFeed(PictureStudio& studio, std::shared_ptr<stream::Channel> channel, Backdrop backdrop, PictureView view);

  void order(PictureOrder order);

  [[nodiscard]] bool shows(const stream::Channel& channel, const PictureView& view) const;

 private:
  // What the picture depends on: equal looks are one picture.
  struct Look {
    std::int64_t revision = -1;  // of the channel; of a flat sheet, the topology's version
    bool has_strains = false;
    friend bool operator==(const Look&, const Look&) = default;
  };

  [[nodiscard]] Look look_of(const stream::Channel::Newest& newest) const;
  void run();
  void fill(const std::vector<PictureOrder>& orders, const stream::Channel::Newest& newest);
  // Of the look, drawn now unless it was before.
  Status draw(const stream::Channel::Newest& newest);
  Result<stream::Bytes> still(const StillFormat& format, const stream::Channel::Newest& newest);
  void film(const PictureOrder& order, FinishedPicture picture);

  PictureStudio& studio_;
  const std::shared_ptr<stream::Channel> channel_;
  const Backdrop backdrop_;
  const PictureView view_;

  std::mutex mutex_;
  std::vector<PictureOrder> waiting_;  // guarded by mutex_
  bool under_way_ = false;             // run() is, or will be; guarded by mutex_

  // Only run() uses these, of which there is one at a time.
  Look look_;
  std::shared_ptr<const DrawnPicture> drawn_;                 // of look_; null: not kept
  std::deque<std::pair<StillFormat, stream::Bytes>> stills_;  // of look_, the last few; see kMaxKeptStills
  render::Camera camera_;                                     // of look_
  double strain_end_ = 0.0;
};

// Draws and encodes the pictures of streams on threads of its own. Thread-safe.
class PictureStudio {
 public:
  // `renderer`: null where no stream is served. All must outlive this.
  PictureStudio(render::Renderer* renderer, PictureCounters& counters, host::Clock& clock, std::size_t num_threads);

  // The one feed of that view of the channel's sheet; it lives as long as somebody holds it.
  std::shared_ptr<PictureFeed> feed(const std::shared_ptr<stream::Channel>& channel, const Backdrop& backdrop,
                                    const PictureView& view);

  // Drops what waits and what comes after; pictures under way are finished. Idempotent.
  void close() { workers_.close(); }
  // close(), and waits for those. Idempotent; not from a thread of the studio.
  void stop() { workers_.stop(); }

 private:
  friend class PictureFeed;
  void submit(std::function<void()> work);

  render::Renderer* const renderer_;
  PictureCounters& counters_;
  host::Clock& clock_;
  std::mutex mutex_;
  std::vector<std::weak_ptr<PictureFeed>> feeds_;  // guarded by mutex_
  BackgroundWorker workers_;
};

}  // namespace kerf::api
