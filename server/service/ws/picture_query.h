#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "kerf/v1/render.pb.h"
#include "server/base/result.h"

// Parses URLs of pictures for an <img>:
//   /sheets/ID.png  /sheets/ID.jpg  /sheets/ID.jpeg
//       ?width= &height= &quality= &color= &wireframe= &undeformed= &dark=
//   /sheets/ID.mjpeg
//       those, and &rate=
// width, height: pixels; quality: of JPEG; color: sides, pieces or strains; wireframe, undeformed, dark: 0 or 1; rate:
// largest number of pictures per second. Ranges and defaults are those of RenderImageRequest and WatchImagesStart.
namespace kerf::ws {

enum class PictureKind { kPng, kJpeg, kMjpeg };

struct PicturePath {
  std::string sheet_name;  // "sheets/ID", as in the URL.
  PictureKind kind = PictureKind::kPng;
};

// Parses a path without its query; returns nothing if it is no path of pictures.
std::optional<PicturePath> parse_picture_path(std::string_view path);

// Decode a query. kInvalidArgument BAD_QUERY with the key as field; the Api checks ranges.
Result<v1::RenderImageRequest> decode_still_query(const PicturePath& path, std::string_view query);
Result<v1::WatchImagesStart> decode_stream_query(const PicturePath& path, std::string_view query);

// Translates an error of the Api about a decoded request into the names that its fields have in the URL.
Error in_words_of_query(Error error);

}  // namespace kerf::ws
