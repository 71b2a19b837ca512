#include "server/service/picture/picture_studio.h"

#include <algorithm>
#include <limits>
#include <string>

#include "server/base/catch_exceptions.h"

namespace kerf::picture {
namespace {

// Number of pixels up to which a picture is kept, so that many large streams do not fill the memory. A larger picture
// is drawn again if it is needed in another format.
constexpr std::int64_t kMaxKeptPixels = render::kMaxVideoPixels;

}  // namespace

PictureFeed::PictureFeed(PictureStudio& studio, std::shared_ptr<stream::Channel> channel, Backdrop backdrop,
                         PictureView view)
    : studio_(studio), channel_(std::move(channel)), backdrop_(std::move(backdrop)), view_(std::move(view)) {}

bool PictureFeed::shows(const stream::Channel& channel, const PictureView& view) const {
  return channel_.get() == &channel && view_ == view;
}

void PictureFeed::order(PictureOrder order) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(order));
    if (std::exchange(under_way_, true)) return;
  }
  studio_.submit([self = shared_from_this()] { self->run(); });
}

// Leaves orders that arrive meanwhile to another turn, behind other feeds.
void PictureFeed::run() {
  std::vector<PictureOrder> orders;
  {
    const std::lock_guard lock(mutex_);
    orders.swap(waiting_);
  }
  fill(orders, channel_->newest());
  {
    const std::lock_guard lock(mutex_);
    under_way_ = !waiting_.empty();
    if (!under_way_) return;
  }
  studio_.submit([self = shared_from_this()] { self->run(); });
}

PictureFeed::Look PictureFeed::look_of(const stream::Channel::Newest& newest) const {
  if (view_.color_by == v1::STRAINS) return {newest.revision, !newest.snapshot->strains.empty(), nullptr};
  return {view_.undeformed ? newest.snapshot->topology->version : newest.revision, false, newest.snapshot->materials};
}

void PictureFeed::fill(const std::vector<PictureOrder>& orders, const stream::Channel::Newest& newest) {
  if (const Look look = look_of(newest); look != look_) {
    look_ = look;
    drawn_.reset();
    stills_.clear();
  }
  for (const PictureOrder& order : orders) {
    FinishedPicture picture{newest.publication, newest.snapshot, {}, 0.0, view_.width, view_.height, true, nullptr};
    if (order.video) {
      if (const Status status = catch_exceptions([&] { return draw(newest); }); !status.ok()) {
        order.done(status.error());
        continue;
      }
      picture.camera = camera_;
      picture.strain_end = strain_end_;
      film(order, std::move(picture));
      continue;
    }
    Result<stream::Bytes> data = catch_exceptions([&] { return still(order.still, newest); });
    if (!data.ok()) {
      order.done(data.error());
      continue;
    }
    picture.camera = camera_;
    picture.strain_end = strain_end_;
    picture.data = std::move(*data);
    order.done(std::move(picture));
  }
  if (std::int64_t{view_.width} * view_.height > kMaxKeptPixels) drawn_.reset();
}

Status PictureFeed::draw(const stream::Channel::Newest& newest) {
  if (drawn_) return Nothing{};
  KERF_TRY_ASSIGN(DrawnPicture picture,
                  draw_picture(*studio_.renderer_, {newest.snapshot, backdrop_}, view_, strain_end_));
  ++studio_.counters_.rendered;
  camera_ = picture.camera;
  strain_end_ = picture.strain_end;
  drawn_ = std::make_shared<const DrawnPicture>(std::move(picture));
  return Nothing{};
}

Result<stream::Bytes> PictureFeed::still(const StillFormat& format, const stream::Channel::Newest& newest) {
  const auto made =
      std::find_if(stills_.begin(), stills_.end(), [&](const auto& each) { return each.first == format; });
  if (made != stills_.end()) {
    ++studio_.counters_.shared;
    return made->second;
  }
  KERF_TRY(draw(newest));
  KERF_TRY_ASSIGN(std::string encoded, encode_still(drawn_->pixels, format));
  ++studio_.counters_.encoded;
  auto data = std::make_shared<const std::string>(std::move(encoded));
  if (stills_.size() == kMaxKeptStills) stills_.pop_front();
  stills_.emplace_back(format, data);
  return stream::Bytes(std::move(data));
}

// Encodes the frame of each stream as work of its own, so that the next picture need not wait for many encoders.
void PictureFeed::film(const PictureOrder& order, FinishedPicture picture) {
  studio_.submit([this, self = shared_from_this(), order, drawn = drawn_, picture = std::move(picture)]() mutable {
    Result<VideoTrack::Frame> frame =
        catch_exceptions([&] { return order.video->encode(drawn->pixels, studio_.clock_.now(), order.key); });
    if (!frame.ok()) return order.done(frame.error());
    ++studio_.counters_.encoded;
    picture.key = frame->key;
    picture.data = std::make_shared<const std::string>(std::move(frame->bytes));
    order.done(std::move(picture));
  });
}

PictureStudio::PictureStudio(render::Renderer* renderer, PictureCounters& counters, host::Clock& clock,
                             std::size_t num_threads)
    : renderer_(renderer),
      counters_(counters),
      clock_(clock),
      // Needs no limit: at most one piece of work waits for each stream, and streams are limited.
      workers_(std::numeric_limits<std::size_t>::max(), num_threads) {}

std::shared_ptr<PictureFeed> PictureStudio::feed(const std::shared_ptr<stream::Channel>& channel,
                                                 const Backdrop& backdrop, const PictureView& view) {
  const std::lock_guard lock(mutex_);
  std::erase_if(feeds_, [](const std::weak_ptr<PictureFeed>& each) { return each.expired(); });
  for (const std::weak_ptr<PictureFeed>& each : feeds_) {
    if (auto feed = each.lock(); feed && feed->shows(*channel, view)) return feed;
  }
  auto feed = std::make_shared<PictureFeed>(*this, channel, backdrop, view);
  feeds_.push_back(feed);
  return feed;
}

void PictureStudio::submit(std::function<void()> work) {
  workers_.submit(std::move(work), [] {});
}

}  // namespace kerf::picture
