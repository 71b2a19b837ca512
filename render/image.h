#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kerf::render {

// Lists outcomes, named as the gRPC status that each becomes on the wire.
enum class StatusCode {
  kOk,
  kInvalidArgument,    // The scene, camera or size is invalid.
  kResourceExhausted,  // The queue is full; a retry may succeed.
  kUnavailable,        // No renderer, shutting down, or the graphics context was lost; a retry may succeed.
  kInternal,           // A bug here or in the driver.
};

// Holds the outcome of a call. This folder includes nothing of the server, so it has a status type of its own.
struct [[nodiscard]] Status {
  StatusCode code = StatusCode::kOk;
  std::string reason;   // UPPER_SNAKE_CASE, stable, for programs, e.g. "CAMERA_SINGULAR"; empty when ok.
  std::string message;  // For people, with the offending number and its limit; empty when ok.
  std::string field;    // The offending argument, e.g. "camera.eye", "scene.mesh.triangles", "width"; may be empty.

  [[nodiscard]] bool ok() const { return code == StatusCode::kOk; }
};

// Holds an image. `rgba` has 4*width*height bytes, rows from top to bottom, sRGB, alpha not premultiplied.
struct Pixels {
  int width = 0;   // pixels
  int height = 0;  // pixels
  std::vector<std::uint8_t> rgba;
};

// False in a build without libpng and libturbojpeg: both encoders then fail with kUnavailable, "NO_IMAGE_CODECS".
[[nodiscard]] bool image_codecs_available();

// Encodes lossless PNG, RGBA, 8 bits per channel. `png` is overwritten; on failure it is empty. Errors: "IMAGE_INVALID"
// (an empty image, or rgba is not 4*width*height bytes), "ENCODING_FAILED".
Status encode_png(const Pixels& pixels, std::vector<std::uint8_t>& png);

// Encodes baseline JPEG without alpha; colour has half resolution below quality 90. `quality` is in [1, 100]; `jpeg` is
// overwritten; on failure it is empty. Errors: as encode_png, and "QUALITY_OUT_OF_RANGE".
Status encode_jpeg(const Pixels& pixels, int quality, std::vector<std::uint8_t>& jpeg);

}  // namespace kerf::render
