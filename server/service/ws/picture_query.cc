#include "server/service/ws/picture_query.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <utility>

namespace kerf::ws {
namespace {

constexpr std::string_view kFolder = "/sheets/";
constexpr std::array<std::pair<std::string_view, PictureKind>, 4> kEndings = {{{".png", PictureKind::kPng},
                                                                               {".jpg", PictureKind::kJpeg},
                                                                               {".jpeg", PictureKind::kJpeg},
                                                                               {".mjpeg", PictureKind::kMjpeg}}};

Error bad_query(std::string_view key, std::string_view value, std::string_view wanted) {
  return invalid_argument(
      "BAD_QUERY", std::string(key) + " is '" + std::string(value.substr(0, 40)) + "'; must be " + std::string(wanted),
      std::string(key));
}

// Parses the whole of `value` as a number.
template <typename Number>
std::optional<Number> parse_number(std::string_view value) {
  Number number{};
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size()) return std::nullopt;
  return number;
}

Status decode_pixels(std::string_view key, std::string_view value, const std::function<void(std::int32_t)>& set) {
  const std::optional<std::int32_t> number = parse_number<std::int32_t>(value);
  if (!number) return bad_query(key, value, "a whole number");
  set(*number);
  return Nothing{};
}

Result<bool> decode_flag(std::string_view key, std::string_view value) {
  if (value == "1") return true;
  if (value == "0") return false;
  return bad_query(key, value, "0 or 1");
}

Result<v1::ColorBy> decode_color(std::string_view value) {
  if (value == "sides") return v1::SIDES;
  if (value == "pieces") return v1::PIECES;
  if (value == "strains") return v1::STRAINS;
  return bad_query("color", value, "sides, pieces or strains");
}

// Decodes a key common to stills and streams; returns nothing for other keys. `view`: a RenderImageRequest or an
// ImageView.
template <typename View>
std::optional<Status> decode_view_key(std::string_view key, std::string_view value, View& view) {
  if (key == "width") return decode_pixels(key, value, [&](std::int32_t pixels) { view.set_width_px(pixels); });
  if (key == "height") return decode_pixels(key, value, [&](std::int32_t pixels) { view.set_height_px(pixels); });
  if (key == "quality") return decode_pixels(key, value, [&](std::int32_t q) { view.set_jpeg_quality(q); });
  if (key == "color") {
    KERF_TRY_ASSIGN(const v1::ColorBy color, decode_color(value));
    view.set_color_by(color);
    return Nothing{};
  }
  if (key != "wireframe" && key != "undeformed" && key != "dark") return std::nullopt;
  KERF_TRY_ASSIGN(const bool flag, decode_flag(key, value));
  if (key == "wireframe") {
    view.set_wireframe(flag);
  } else if (key == "dark") {
    view.set_dark(flag);
  } else {
    view.set_undeformed(flag);
  }
  return Nothing{};
}

// Calls `decode` with each key and value. If it returns nothing the key is unknown; the error then lists `keys`.
Status decode_query(std::string_view query, std::string_view keys,
                    const std::function<std::optional<Status>(std::string_view, std::string_view)>& decode) {
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view entry = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    const std::size_t equals = std::min(entry.find('='), entry.size());
    const std::string_view key = entry.substr(0, equals);
    const std::string_view value = entry.substr(std::min(equals + 1, entry.size()));
    const std::optional<Status> decoded = decode(key, value);
    if (!decoded) {
      return invalid_argument(
          "BAD_QUERY", "unknown parameter '" + std::string(key.substr(0, 40)) + "'; there are " + std::string(keys),
          std::string(key.substr(0, 40)));
    }
    if (!decoded->ok()) return decoded->error();
  }
  return Nothing{};
}

constexpr std::string_view kStillKeys = "width, height, quality, color, wireframe, undeformed and dark";
constexpr std::string_view kStreamKeys = "width, height, rate, quality, color, wireframe, undeformed and dark";

void replace_first(std::string& text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  if (at != std::string::npos) text.replace(at, from.size(), to);
}

}  // namespace

std::optional<PicturePath> parse_picture_path(std::string_view path) {
  if (!path.starts_with(kFolder)) return std::nullopt;
  for (const auto& [ending, kind] : kEndings) {
    if (!path.ends_with(ending) || path.size() == kFolder.size() + ending.size()) continue;
    return PicturePath{std::string(path.substr(1, path.size() - 1 - ending.size())), kind};
  }
  return std::nullopt;
}

Result<v1::RenderImageRequest> decode_still_query(const PicturePath& path, std::string_view query) {
  v1::RenderImageRequest request;
  request.set_name(path.sheet_name);
  request.set_format(path.kind == PictureKind::kPng ? v1::RenderImageRequest::PNG : v1::RenderImageRequest::JPEG);
  KERF_TRY(decode_query(query, kStillKeys, [&](std::string_view key, std::string_view value) {
    return decode_view_key(key, value, request);
  }));
  return request;
}

Result<v1::WatchImagesStart> decode_stream_query(const PicturePath& path, std::string_view query) {
  v1::WatchImagesStart start;
  start.set_name(path.sheet_name);
  start.set_codec(v1::IMAGE_JPEG);
  KERF_TRY(decode_query(query, kStreamKeys, [&](std::string_view key, std::string_view value) -> std::optional<Status> {
    if (key != "rate") return decode_view_key(key, value, *start.mutable_view());
    const std::optional<double> rate = parse_number<double>(value);
    if (!rate) return bad_query(key, value, "a number of pictures a second");
    start.set_max_rate_hz(*rate);
    return Nothing{};
  }));
  return start;
}

Error in_words_of_query(Error error) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kNames = {
      {{"width_px", "width"}, {"height_px", "height"}, {"jpeg_quality", "quality"}, {"max_rate_hz", "rate"}}};
  for (const std::string_view prefix : {"start.view.", "start."}) {
    if (!error.field.starts_with(prefix)) continue;
    replace_first(error.message, prefix, "");
    error.field.erase(0, prefix.size());
  }
  for (const auto& [name, query_name] : kNames) {
    if (error.field != name) continue;
    replace_first(error.message, name, query_name);
    error.field = query_name;
  }
  return error;
}

}  // namespace kerf::ws
