#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kerf::render {

// Named as the gRPC status each becomes on the wire.
enum class StatusCode {
  kOk,
  kInvalidArgument,    // the scene, camera or size would never do
  kResourceExhausted,  // the queue is full; may work later
  kUnavailable,        // no renderer, shutting down, or the graphics context was lost; may work later
  kInternal,           // our bug, or the driver's
};

// The outcome of a call. This folder includes nothing of the server, hence a type of its own.
struct [[nodiscard]] Status {
  StatusCode code = StatusCode::kOk;
  std::string reason;   // UPPER_SNAKE_CASE, stable, for programs, e.g. "CAMERA_SINGULAR"; empty when ok
  std::string message;  // for people: what is wrong, with the number and the limit; empty when ok
  std::string field;    // the offending argument, e.g. "camera.eye", "scene.mesh.triangles", "width"; may be empty

  [[nodiscard]] bool ok() const { return code == StatusCode::kOk; }
};

// An image. `rgba` holds 4*width*height bytes, rows from top to bottom, sRGB, alpha not premultiplied.
struct Pixels {
  int width = 0;   // pixels
  int height = 0;  // pixels
  std::vector<std::uint8_t> rgba;
};

// False in a build without libpng and libturbojpeg: both encoders then refuse with kUnavailable, "NO_IMAGE_CODECS".
[[nodiscard]] bool image_codecs_available();

// Lossless PNG, RGBA, 8 bits a channel. `png` is overwritten; on failure it is empty.
// Errors: "IMAGE_INVALID" (an empty image, or rgba is not 4*width*height bytes), "ENCODING_FAILED".
Status encode_png(const Pixels& pixels, std::vector<std::uint8_t>& png);

// Baseline JPEG, alpha dropped; colour at half resolution below quality 90. `quality` is in [1, 100]; `jpeg` is
// overwritten; on failure it is empty. Errors: as encode_png, and "QUALITY_OUT_OF_RANGE".
Status encode_jpeg(const Pixels& pixels, int quality, std::vector<std::uint8_t>& jpeg);

}  // namespace kerf::render
