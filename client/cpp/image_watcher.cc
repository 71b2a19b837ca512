#include "client/cpp/image_watcher.h"

namespace kerf::client {
namespace {

v1::ImageView view_of(const ImageLook& look) {
  v1::ImageView view;
  view.set_width_px(look.width_px);
  view.set_height_px(look.height_px);
  if (look.camera) *view.mutable_camera() = *look.camera;
  view.set_wireframe(look.wireframe);
  view.set_undeformed(look.undeformed);
  view.set_color_by(look.color_by);
  view.set_jpeg_quality(look.jpeg_quality);
  view.set_bitrate_kbps(look.bitrate_kbps);
  view.set_dark(look.dark);
  return view;
}

v1::WatchImagesRequest start_of(const std::string& name, const ImageOptions& options) {
  v1::WatchImagesRequest request;
  v1::WatchImagesStart& start = *request.mutable_start();
  start.set_name(name);
  start.set_window(options.window);
  start.set_max_rate_hz(options.max_rate_hz);
  start.set_codec(options.codec);
  *start.mutable_view() = view_of(options.look);
  return request;
}

}  // namespace

grpc::Status ImageWatcher::run(const std::string& name, const ImageOptions& options, const OnImage& on_image) {
  using Taken = LiveStream<v1::WatchImagesRequest, v1::WatchImagesResponse>::Taken;
  const auto open = [this](grpc::ClientContext* context) { return client_.render().WatchImages(context); };
  const auto start = [&] { return start_of(name, options); };
  const auto take = [&](const v1::WatchImagesResponse& response) -> Taken {
    if (!response.has_image()) return {};
    const std::int64_t sequence = response.image().sequence();
    if (on_image(response.image())) return {sequence, {}};
    return {sequence, grpc::Status::OK};
  };
  const auto connect = [this](std::chrono::milliseconds timeout) { return client_.wait_until_connected(timeout); };
  return stream_.run(open, start, take, connect, options.reopening);
}

void ImageWatcher::set_look(const ImageLook& look) {
  v1::WatchImagesRequest request;
  *request.mutable_view() = view_of(look);
  stream_.set(request);
}

void ImageWatcher::set_pace(double max_rate_hz, bool paused) {
  v1::WatchImagesRequest request;
  request.mutable_pace()->set_max_rate_hz(max_rate_hz);
  request.mutable_pace()->set_paused(paused);
  stream_.set(request);
}

}  // namespace kerf::client
