#include <atomic>
#include <string>
#include <thread>
#include <utility>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "client/load/viewer.h"

namespace kerf::load {
namespace {

class ImageViewer : public Viewer {
 public:
  ImageViewer(const Plan& plan, Watching watching, Recorder& recorder)
      : plan_(plan),
        watching_(std::move(watching)),
        client_(connect_to(watching_.address, plan, client::Client::Connection::kOwn)),
        log_(plan, watching_, recorder),
        thread_([this] { run(); }) {}
  ~ImageViewer() override {
    stop();
    thread_.join();
  }
  void stop() override {
    stopped_ = true;
    context_.TryCancel();
  }

 private:
  void run() {
    client_.wait_until_connected(kConnectWithin);
    const auto stream = client_.render().WatchImages(&context_);
    v1::WatchImagesRequest start;
    start.mutable_start()->set_name(watching_.sheet);
    start.mutable_start()->mutable_view()->set_width_px(plan_.image_width);
    start.mutable_start()->mutable_view()->set_height_px(plan_.image_height);
    stream->Write(start);
    v1::WatchImagesResponse response;
    v1::Ended ended;
    while (stream->Read(&response)) {
      const Nanoseconds arrived = now();
      if (response.has_ended()) ended = response.ended();
      if (!response.has_image()) continue;
      const v1::Image& image = response.image();
      // Does not decode the picture: its age is that of the bytes.
      log_.seen(image.tick(), 0, image.stats(), static_cast<std::int64_t>(image.ByteSizeLong()), image.key());
      v1::WatchImagesRequest ack;
      ack.mutable_ack()->set_sequence(image.sequence());
      ack.mutable_ack()->set_held_us(1 + microseconds(now() - arrived));
      stream->Write(ack);
    }
    const grpc::Status status = stream->Finish();
    log_.finish();
    if (stopped_) return;
    if (ended.reason() != v1::Ended::REASON_UNSPECIFIED) {
      log_.ended(v1::Ended::Reason_Name(ended.reason()));
    } else {
      log_.ended(status.ok() ? "OK" : client::reason_of(status));
    }
  }

  const Plan& plan_;
  const Watching watching_;
  std::atomic<bool> stopped_{false};
  client::Client client_;
  grpc::ClientContext context_;
  ReaderLog log_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Viewer> watch_images(const Plan& plan, const Watching& watching, Recorder& recorder) {
  return std::make_unique<ImageViewer>(plan, watching, recorder);
}

}  // namespace kerf::load
