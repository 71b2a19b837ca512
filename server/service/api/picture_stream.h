#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "kerf/v1/render.pb.h"
#include "server/service/api/core.h"
#include "server/service/api/image_request.h"
#include "server/service/api/image_session.h"
#include "server/service/host/wake_callback.h"
#include "server/service/host/wake_timer.h"

namespace kerf::v1 {
class WatchAck;
class WatchPace;
}  // namespace kerf::v1

namespace kerf::api {

// Serves the pictures of one image stream. It orders a picture from its feed when there is something new to show and
// its FlowControl allows it to send. It sends the picture once the feed has finished it. Thus no picture is drawn that
// is not sent, and at most one order is open at a time.
class PictureStream final : public ImageSession,
                            public OpenStream,
                            public stream::Reader,
                            public std::enable_shared_from_this<PictureStream> {
 public:
  PictureStream(std::shared_ptr<ApiCore> core, auth::Caller caller)
      : core_(std::move(core)), caller_(std::move(caller)), timer_(core_->clock) {}
  ~PictureStream() override { close(); }

  void on_bytes(std::string_view bytes) override;
  std::optional<stream::Message> next() override;
  std::optional<stream::Bytes> next_picture() override;
  void set_wake(std::function<void()> wake) override;
  [[nodiscard]] bool ended() const override;
  [[nodiscard]] std::optional<Error> failure() const override;
  void close() override;
  void server_stops() override;
  void check_caller() override;

  void wake() override;
  void end(wire::EndReason reason) override;
  void leave() override;

  void fail(Error error);
  // `acknowledges`: the client acknowledges pictures.
  void start(const v1::WatchImagesStart& request, bool acknowledges);

 private:
  void join();
  void joined(const Status& status);
  void shown(const Result<picture::Backdrop>& backdrop);
  void acknowledge(const v1::WatchAck& ack);
  void look(const v1::ImageView& view);
  void set_frame_rate(const v1::WatchPace& pace);
  [[nodiscard]] bool started() const;

  struct Outgoing {
    std::optional<wire::EndReason> end;  // To be sent; no message follows.
    v1::Image image;                     // Without data.
    stream::Bytes data;                  // Null: no picture now.
  };
  // Returns the next message. If there is none it orders a picture or sets a timer.
  Outgoing advance();
  // These need mutex_ held:
  void order(const stream::FlowControl::Permit& permit);
  v1::Image send(const picture::FinishedPicture& picture, host::Nanoseconds now);
  void take_look(const ImageLook& look);
  void wake_at(const std::optional<host::Nanoseconds>& deadline);
  [[nodiscard]] bool wants_strains() const { return look_.view.color_by == v1::STRAINS; }
  [[nodiscard]] bool over() const { return closed_ || failure_ || ended_; }

  void finished(Result<picture::FinishedPicture> picture);
  // Leaves the sheet and frees the stream's resources; once.
  void let_go();

  const std::shared_ptr<ApiCore> core_;
  const auth::Caller caller_;
  host::WakeCallback wake_;
  host::WakeTimer timer_;
  std::string sheet_id_;  // Like codec_, written by start() before anything reads it.
  v1::ImageCodec codec_ = v1::IMAGE_JPEG;
  // advance() could have ordered a picture, but found nothing new: wake() must call wake_.
  std::atomic<bool> wants_picture_{true};

  mutable std::mutex mutex_;  // Guards the members below; not held over calls to the host or the hub.
  bool started_ = false;
  bool joined_ = false;                   // Joined to the hub, which it must leave.
  bool counted_ = false;                  // Counted in ApiCore::num_image_streams.
  std::shared_ptr<Audience::Seat> seat_;  // Set once it has joined.
  std::shared_ptr<const void> place_;     // Among the streams of its tenant.
  ImageLook look_;
  std::optional<stream::FlowControl> flow_;  // Set once started.
  bool paused_ = false;
  // Publications up to this number are not shown: the one before a pause ended, and older ones.
  std::int64_t stale_through_ = 0;
  std::shared_ptr<stream::Channel> channel_;
  std::optional<picture::Backdrop> backdrop_;
  std::shared_ptr<picture::PictureFeed> feed_;  // Set once there is a backdrop.
  std::shared_ptr<picture::VideoTrack> video_;  // For VP8.
  bool key_wanted_ = false;                     // The next video frame must be decodable by itself.
  bool look_changed_ = false;                   // A picture is due though the sheet has not moved.
  bool ordered_ = false;
  std::optional<picture::FinishedPicture> picture_;  // To be sent.
  std::int64_t last_publication_ = 0;                // Number of the publication shown by the last picture sent.
  std::int64_t last_tick_ = -1;                      // Tick of the last picture sent; -1: none.
  std::optional<wire::EndReason> end_;               // Reason of the end, once the stream is to end.
  bool ended_ = false;                               // The end was sent.
  std::optional<Error> failure_;
  bool closed_ = false;
};

}  // namespace kerf::api
