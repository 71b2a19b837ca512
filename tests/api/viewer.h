#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "server/service/api/api.h"
#include "server/service/api/watch_session.h"
#include "tests/wire/frame_mirror.h"

namespace kerf::api {

// The client's end of a session, with no transport in between.
class Viewer {
 public:
  explicit Viewer(Api& api) : Viewer(api.watch()) {}
  explicit Viewer(std::shared_ptr<WatchSession> session) : session_(std::move(session)) {
    session_->set_wake([woken = woken_] { ++*woken; });
  }

  void start(const std::string& name, int window = 0, double max_rate_hz = 0.0) {
    v1::WatchRequest request;
    request.mutable_start()->set_name(name);
    request.mutable_start()->set_window(window);
    request.mutable_start()->set_max_rate_hz(max_rate_hz);
    session_->on_request(request);
  }
  void acknowledge(std::int64_t sequence, std::int64_t held_us = 0) {
    v1::WatchRequest request;
    request.mutable_ack()->set_sequence(sequence);
    request.mutable_ack()->set_held_us(held_us);
    session_->on_request(request);
  }
  void set_frame_rate(double max_rate_hz, bool paused) {
    v1::WatchRequest request;
    request.mutable_pace()->set_max_rate_hz(max_rate_hz);
    request.mutable_pace()->set_paused(paused);
    session_->on_request(request);
  }
  void grab(const std::string& id, int vertex) {
    v1::WatchRequest request;
    request.mutable_grab()->set_grab_id(id);
    request.mutable_grab()->set_vertex(vertex);
    session_->on_bytes(request.SerializeAsString());
  }
  void drag(const std::string& id, double z) {
    v1::WatchRequest request;
    request.mutable_drag()->set_grab_id(id);
    request.mutable_drag()->mutable_target()->set_z(z);
    session_->on_request(request);
  }
  void release(const std::string& id) {
    v1::WatchRequest request;
    request.mutable_release()->set_grab_id(id);
    session_->on_request(request);
  }

  std::optional<v1::WatchResponse> next() {
    const std::optional<stream::Message> message = session_->next();
    if (!message) return std::nullopt;
    v1::WatchResponse response;
    EXPECT_TRUE(response.ParseFromString(message->joined()));
    return response;
  }
  // Takes and acknowledges everything there is; true if a frame was among it.
  bool drain() {
    bool any = false;
    while (const auto response = next()) {
      if (!response->has_frame()) {
        others.push_back(*response);
        continue;
      }
      EXPECT_EQ(mirror.apply(response->frame()), std::nullopt);
      acknowledge(mirror.sequence);
      any = true;
    }
    return any;
  }
  [[nodiscard]] std::string failure() const {
    const auto error = session_->failure();
    return error ? error->reason : "";
  }

  WatchSession& session() { return *session_; }
  [[nodiscard]] int woken() const { return *woken_; }
  void forget() { session_.reset(); }

  kerf::testing::FrameMirror mirror;
  std::vector<v1::WatchResponse> others;

 private:
  std::shared_ptr<std::atomic<int>> woken_ = std::make_shared<std::atomic<int>>(0);
  std::shared_ptr<WatchSession> session_;
};

}  // namespace kerf::api
