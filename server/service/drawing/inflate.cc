#include "server/service/drawing/inflate.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include <zlib.h>

#include "server/base/check.h"

namespace kerf::drawing {
namespace {

constexpr std::size_t kStep = std::size_t{64} << 10;
constexpr int kGzip = 16 + MAX_WBITS;

struct Inflated {
  std::string text;  // Up to a fault, or up to a step beyond `max_bytes`.
  bool is_whole = false;
};

Inflated inflate_up_to(std::size_t max_bytes, std::string_view data) {
  Inflated result;
  std::string& text = result.text;
  z_stream stream{};
  if (inflateInit2(&stream, kGzip) != Z_OK) return result;
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, &inflateEnd);
  // zlib's interface predates const; it does not write to its input.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(data.size(), std::numeric_limits<uInt>::max()));
  while (text.size() <= max_bytes) {
    const std::size_t before = text.size();
    text.resize(before + kStep);
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
    stream.avail_out = static_cast<uInt>(kStep);
    const int state = inflate(&stream, Z_NO_FLUSH);
    text.resize(text.size() - stream.avail_out);
    if (state == Z_STREAM_END) {
      result.is_whole = !is_gzip({reinterpret_cast<const char*>(stream.next_in), stream.avail_in});
      if (result.is_whole || inflateReset(&stream) != Z_OK) return result;
    } else if (state != Z_OK) {
      return result;
    }
  }
  return result;
}

}  // namespace

bool is_gzip(std::string_view data) {
  return data.substr(0, 2) == "\x1f\x8b";
}

Result<std::string> inflated(std::string_view data, const std::string& kind, const std::string& field,
                             std::size_t max_bytes) {
  Inflated inflated = inflate_up_to(max_bytes, data);
  if (inflated.text.size() > max_bytes) {
    return invalid_argument(kind + "_TOO_LARGE",
                            "the file has more than " + std::to_string(max_bytes >> 20U) + " MiB when decompressed",
                            field);
  }
  if (!inflated.is_whole) {
    return invalid_argument(kind + "_MALFORMED", "the gzip data of the file is damaged or cut off", field);
  }
  if (is_gzip(inflated.text)) {
    return invalid_argument(kind + "_MALFORMED", "the file was compressed twice by gzip; decompress it once", field);
  }
  return std::move(inflated.text);
}

std::string inflated_start(std::string_view data, std::size_t num_bytes) {
  std::string text = inflate_up_to(num_bytes, data).text;
  text.resize(std::min(text.size(), num_bytes));
  return text;
}

std::string gzipped(std::string_view data) {
  z_stream stream{};
  KERF_CHECK(deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) == Z_OK,
             "zlib has memory");
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, &deflateEnd);
  std::string result(deflateBound(&stream, data.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  KERF_CHECK(deflate(&stream, Z_FINISH) == Z_STREAM_END, "the room is that of deflateBound()");
  result.resize(result.size() - stream.avail_out);
  return result;
}

}  // namespace kerf::drawing
