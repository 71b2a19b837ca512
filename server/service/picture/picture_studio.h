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

namespace kerf::picture {
class PictureStudio;
}  // namespace kerf::picture

namespace kerf::picture {

// Counts the work done so far, for metrics and for tests that nothing is done in vain or twice.
struct PictureCounters {
  std::atomic<std::int64_t> rendered{0};
  std::atomic<std::int64_t> encoded{0};
  // Encoded pictures given to a stream that had been made for another stream, or for an earlier order of this one.
  std::atomic<std::int64_t> shared{0};
  std::atomic<std::int64_t> sent{0};     // Sent to streams.
  std::atomic<std::int64_t> skipped{0};  // Ticks between two pictures of a stream, which it did not show.
};

// Holds a finished picture of a stream.
struct FinishedPicture {
  std::int64_t publication = 0;                     // Number of the publication shown.
  std::shared_ptr<const sheet::Snapshot> snapshot;  // The snapshot shown.
  render::Camera camera;                            // The camera used.
  double strain_end = 0.0;                          // Strain at the end of the colour scale; 0: no strains are shown.
  int width = 0;                                    // pixels
  int height = 0;                                   // pixels
  bool key = true;                                  // Can be decoded by itself.
  stream::Bytes data;                               // never null
};

// Describes the next picture that a stream wants from a feed.
struct PictureOrder {
  StillFormat still;                  // Used without video.
  std::shared_ptr<VideoTrack> video;  // The stream's own video encoder; null: a still is wanted.
  bool key = false;                   // Requests a video frame that can be decoded by itself.
  // Called once, on a thread of the studio, with no lock of it held; not at all once the studio has stopped.
  std::function<void(Result<FinishedPicture>)> done;
};

// Limit on the formats in which the encoding of one picture is kept. The latest are kept; other formats are encoded
// again.
inline constexpr std::size_t kMaxKeptStills = 4;

// Serves one view of one sheet to all streams that share it. An order gets a picture of the tick that is the newest
// when the order's turn comes. A picture that is already drawn of that tick is reused, and so is its encoding in the
// same format. At most one picture is being drawn. Thread-safe.
class PictureFeed : public std::enable_shared_from_this<PictureFeed> {
 public:
  // Use PictureStudio::feed() instead. The channel must have a snapshot before the first order.
  PictureFeed(PictureStudio& studio, std::shared_ptr<stream::Channel> channel, Backdrop backdrop, PictureView view);

  void order(PictureOrder order);

  [[nodiscard]] bool shows(const stream::Channel& channel, const PictureView& view) const;

 private:
  // Identifies the content of a picture: equal looks give the same picture.
  struct Look {
    // Channel::Newest::revision; for undeformed views without strains, the topology version.
    std::int64_t revision = -1;
    bool has_strains = false;
    std::shared_ptr<const scene::SheetMaterials> materials;
    friend bool operator==(const Look&, const Look&) = default;
  };

  [[nodiscard]] Look look_of(const stream::Channel::Newest& newest) const;
  void run();
  void fill(const std::vector<PictureOrder>& orders, const stream::Channel::Newest& newest);
  // Draws look_, which is that of `newest`, unless it is already drawn.
  Status draw(const stream::Channel::Newest& newest);
  Result<stream::Bytes> still(const StillFormat& format, const stream::Channel::Newest& newest);
  void film(const PictureOrder& order, FinishedPicture picture);

  PictureStudio& studio_;
  const std::shared_ptr<stream::Channel> channel_;
  const Backdrop backdrop_;
  const PictureView view_;

  std::mutex mutex_;
  std::vector<PictureOrder> waiting_;  // guarded by mutex_
  bool under_way_ = false;             // run() is in progress or posted; guarded by mutex_.

  // Used only by run(), of which one runs at a time.
  Look look_;
  std::shared_ptr<const DrawnPicture> drawn_;                 // Picture of look_; null: not kept.
  std::deque<std::pair<StillFormat, stream::Bytes>> stills_;  // Encodings of look_, the last few; see kMaxKeptStills.
  render::Camera camera_;                                     // Camera of look_.
  double strain_end_ = 0.0;
};

// Draws and encodes the pictures of streams on its own threads. Thread-safe.
class PictureStudio {
 public:
  // `renderer`: null if no stream is served. All references must outlive this.
  PictureStudio(render::Renderer* renderer, PictureCounters& counters, host::Clock& clock, std::size_t num_threads);

  // Returns the feed that draws this view of the channel's sheet. All callers with an equal view share it; it lives
  // while any of them holds it.
  std::shared_ptr<PictureFeed> feed(const std::shared_ptr<stream::Channel>& channel, const Backdrop& backdrop,
                                    const PictureView& view);

  // Drops waiting and later work; pictures in progress are finished. Idempotent.
  void close() { workers_.close(); }
  // Calls close() and waits for the pictures in progress. Idempotent. Must not be called on a thread of the studio.
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

}  // namespace kerf::picture
