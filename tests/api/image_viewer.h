#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "kerf/v1/render.pb.h"
#include "server/service/api/api.h"
#include "server/service/api/image_session.h"

namespace kerf::api {

// The client's end of an image stream, with no transport in between.
class ImageViewer {
 public:
  explicit ImageViewer(Api& api) : ImageViewer(api.watch_images()) {}
  explicit ImageViewer(std::shared_ptr<ImageSession> session) : session_(std::move(session)) {
    session_->set_wake([signal = signal_] {
      const std::lock_guard lock(signal->mutex);
      ++signal->count;
      signal->raised.notify_all();
    });
  }

  static v1::WatchImagesRequest start_of(const std::string& name) {
    v1::WatchImagesRequest request;
    request.mutable_start()->set_name(name);
    request.mutable_start()->mutable_view()->set_width_px(32);
    request.mutable_start()->mutable_view()->set_height_px(16);
    return request;
  }
  void send(const v1::WatchImagesRequest& request) { session_->on_bytes(request.SerializeAsString()); }
  void start(const std::string& name, int window = 0, double max_rate_hz = 0.0) {
    v1::WatchImagesRequest request = start_of(name);
    request.mutable_start()->set_window(window);
    request.mutable_start()->set_max_rate_hz(max_rate_hz);
    send(request);
  }
  void acknowledge(std::int64_t sequence) {
    v1::WatchImagesRequest request;
    request.mutable_ack()->set_sequence(sequence);
    send(request);
  }
  void set_frame_rate(double max_rate_hz, bool paused) {
    v1::WatchImagesRequest request;
    request.mutable_pace()->set_max_rate_hz(max_rate_hz);
    request.mutable_pace()->set_paused(paused);
    send(request);
  }
  void look(const v1::ImageView& view) {
    v1::WatchImagesRequest request;
    *request.mutable_view() = view;
    send(request);
  }

  // Returns the next message, as a transport would; orders a picture if one is due.
  std::optional<v1::WatchImagesResponse> next() {
    const std::optional<stream::Message> message = session_->next();
    if (!message) return std::nullopt;
    v1::WatchImagesResponse response;
    EXPECT_TRUE(response.ParseFromString(message->joined()));
    return response;
  }
  // Waits for the next message; an empty one, and a failure of the test, if none comes or the stream ends.
  v1::WatchImagesResponse wait_for_message() {
    while (true) {
      const int seen = woken();
      if (std::optional<v1::WatchImagesResponse> response = next()) return *response;
      if (session_->ended() || !wait_until_woken(seen)) {
        ADD_FAILURE() << "no picture: " << failure();
        return {};
      }
    }
  }
  // Waits for the next picture and acknowledges it.
  v1::Image picture() {
    const v1::Image image = wait_for_message().image();
    acknowledge(image.sequence());
    return image;
  }
  // Waits until the stream is refused.
  std::string wait_for_failure() {
    while (failure().empty()) {
      const int seen = woken();
      next();
      if (failure().empty() && !wait_until_woken(seen)) break;
    }
    return failure();
  }

  [[nodiscard]] std::string failure() const {
    const auto error = session_->failure();
    return error ? error->reason : "";
  }
  ImageSession& session() { return *session_; }

 private:
  struct Signal {
    std::mutex mutex;
    std::condition_variable raised;
    int count = 0;
  };

  [[nodiscard]] int woken() const {
    const std::lock_guard lock(signal_->mutex);
    return signal_->count;
  }
  // False if nothing has happened for long.
  bool wait_until_woken(int seen) {
    std::unique_lock lock(signal_->mutex);
    return signal_->raised.wait_for(lock, std::chrono::seconds(60), [&] { return signal_->count != seen; });
  }

  std::shared_ptr<Signal> signal_ = std::make_shared<Signal>();
  std::shared_ptr<ImageSession> session_;
};

}  // namespace kerf::api
