#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <grpcpp/support/status.h>

#include "client/cpp/client.h"
#include "client/cpp/live_stream.h"

namespace kerf::client {

// How the pictures of a stream look.
struct ImageLook {
  std::int32_t width_px = 640;            // 16..4096; VP8: at most 2,304,000 pixels a picture
  std::int32_t height_px = 360;           // 16..4096
  std::optional<v1::Camera> camera = {};  // absent: all of the sheet, anew for each picture
  bool wireframe = false;
  bool undeformed = false;  // as it is cut, but flat
  v1::ColorBy color_by = v1::SIDES;
  std::int32_t jpeg_quality = 0;  // 1..100; 0: 80
  std::int32_t bitrate_kbps = 0;  // of VP8, 50..50000; 0: by the size
  bool dark = false;              // before a dark backdrop
};

struct ImageOptions {
  ImageLook look = {};
  v1::ImageCodec codec =
      v1::IMAGE_JPEG;        // or IMAGE_PNG, or IMAGE_VP8: frames of one stream, for a decoder of one's own
  std::int32_t window = 0;   // pictures in flight, 1..8; 0: what way and reader want
  double max_rate_hz = 0.0;  // 0.001..1000; 0: every tick
  Reopening reopening = {};  // as of WatchOptions
};

// Watches one sheet in pictures that the server draws: reads, acknowledges. Blocks the thread that calls run().
class ImageWatcher {
 public:
  // Called with each picture; return false to stop.
  using OnImage = std::function<bool(const v1::Image& image)>;

  explicit ImageWatcher(Client& client) : client_(client) {}  // for one run()

  // Watches `name` ("sheets/demo") until on_image says stop, stop() is called, the server ends the stream, or it fails.
  // OK in the first three cases; UNAVAILABLE where the server draws no pictures. The server is told how long on_image
  // took, so that a slow one is given newer pictures; those that it misses are not drawn.
  grpc::Status run(const std::string& name, const ImageOptions& options, const OnImage& on_image);

  // From any thread: what is seen from the next picture on. The look that there is already: the next VP8 frame can be
  // decoded by itself, for a reader that lost its place.
  void set_look(const ImageLook& look);
  // From any thread: as Watcher::set_pace().
  void set_pace(double max_rate_hz, bool paused = false);
  // From any thread: ends run().
  void stop() { stream_.stop(); }

  // Why the server ended the stream, if it did.
  [[nodiscard]] const v1::Ended& ended() const { return stream_.ended(); }

 private:
  Client& client_;
  LiveStream<v1::WatchImagesRequest, v1::WatchImagesResponse> stream_;
};

}  // namespace kerf::client
