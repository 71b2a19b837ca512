#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "kerf/v1/render.pb.h"
#include "server/base/result.h"

// Pictures at URLs that an <img> can show:
//   /sheets/ID.png  /sheets/ID.jpg  /sheets/ID.jpeg
//       ?width= &height= &quality= &color= &wireframe= &undeformed= &dark=
//   /sheets/ID.mjpeg
//       those, and &rate=
// width, height: pixels; quality: of JPEG; color: sides, pieces or strains; wireframe, undeformed, dark: 0 or 1;
// rate: pictures a second at most. Ranges and defaults are those of RenderImageRequest and WatchImagesStart.
namespace kerf::ws {

enum class PictureKind { kPng, kJpeg, kMjpeg };

struct PicturePath {
  std::string sheet_name;  // "sheets/ID", as the URL has it
  PictureKind kind = PictureKind::kPng;
};

// Nothing where there are no pictures at `path` (without its query).
std::optional<PicturePath> parse_picture_path(std::string_view path);

// kInvalidArgument BAD_QUERY with the key as field; ranges are left to the Api.
Result<v1::RenderImageRequest> decode_still_query(const PicturePath& path, std::string_view query);
Result<v1::WatchImagesStart> decode_stream_query(const PicturePath& path, std::string_view query);

// An error of the Api about such a request, in the words of the URL: its fields bear other names there.
Error in_words_of_query(Error error);

}  // namespace kerf::ws
