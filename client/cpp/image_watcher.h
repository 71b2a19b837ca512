#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <grpcpp/support/status.h>

#include "client/cpp/client.h"
#include "client/cpp/live_stream.h"

namespace kerf::client {

// Describes the look of a stream's pictures.
struct ImageLook {
  std::int32_t width_px = 640;            // 16..4096; VP8: at most 2,304,000 pixels per picture.
  std::int32_t height_px = 360;           // 16..4096
  std::optional<v1::Camera> camera = {};  // Absent: each picture shows the whole sheet.
  bool wireframe = false;
  bool undeformed = false;  // Shows the sheet flat, with its cuts.
  v1::ColorBy color_by = v1::SIDES;
  std::int32_t jpeg_quality = 0;  // 1..100; 0: 80
  std::int32_t bitrate_kbps = 0;  // VP8 only, 50..50000; 0: chosen by the size of pictures.
  bool dark = false;              // Draws before a dark background.
};

struct ImageOptions {
  ImageLook look = {};
  v1::ImageCodec codec = v1::IMAGE_JPEG;  // Or IMAGE_PNG; or IMAGE_VP8, whose frames the program has to decode.
  std::int32_t window = 0;   // Pictures sent and not acknowledged, 1..8; 0: adapts to connection and reader.
  double max_rate_hz = 0.0;  // 0.001..1000; 0: every tick
  Reopening reopening = {};  // As in WatchOptions.
};

// Watches one sheet in pictures drawn by the server: reads and acknowledges them. Blocks the thread that calls run().
class ImageWatcher {
 public:
  // Called with each picture; return false to stop.
  using OnImage = std::function<bool(const v1::Image& image)>;

  explicit ImageWatcher(Client& client) : client_(client) {}  // Allows one run().

  // Watches `name` ("sheets/demo") until on_image returns false, stop() is called, the server ends the stream, or the
  // stream fails. OK in the first three cases; UNAVAILABLE if the server draws no pictures. The server learns how long
  // on_image takes: a slow one gets fewer pictures, each of the newest tick, and the others are not drawn.
  grpc::Status run(const std::string& name, const ImageOptions& options, const OnImage& on_image);

  // Sets the look from the next picture on, from any thread. Setting the present look makes the next VP8 frame
  // decodable by itself, for a reader that lost its place.
  void set_look(const ImageLook& look);
  // As Watcher::set_pace(); callable from any thread.
  void set_pace(double max_rate_hz, bool paused = false);
  // Ends run(); callable from any thread.
  void stop() { stream_.stop(); }

  // Returns the reason why the server ended the stream, if it did.
  [[nodiscard]] const v1::Ended& ended() const { return stream_.ended(); }

 private:
  Client& client_;
  LiveStream<v1::WatchImagesRequest, v1::WatchImagesResponse> stream_;
};

}  // namespace kerf::client
