#include "server/service/drawing/inflate.h"

#include <algorithm>
#include <memory>

#include <zlib.h>

#include "server/base/check.h"

namespace kerf::drawing {
namespace {

constexpr std::size_t kStep = std::size_t{64} << 10;
constexpr int kGzip = 16 + MAX_WBITS;

}  // namespace

bool is_gzip(std::string_view data) {
  return data.substr(0, 2) == "\x1f\x8b";
}

Result<std::string> inflated(std::string_view data, const std::string& kind, const std::string& field) {
  const Error broken = invalid_argument(kind + "_MALFORMED", "the gzip data of the drawing is damaged", field);
  z_stream stream{};
  if (inflateInit2(&stream, kGzip) != Z_OK) return broken;
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, &inflateEnd);
  // zlib's interface predates const; it does not write to its input.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(data.size(), kMaxInflatedBytes));
  std::string text;
  while (true) {
    const std::size_t before = text.size();
    text.resize(before + kStep);
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
    stream.avail_out = static_cast<uInt>(kStep);
    const int state = inflate(&stream, Z_NO_FLUSH);
    text.resize(text.size() - stream.avail_out);
    if (text.size() > kMaxInflatedBytes) {
      return invalid_argument(kind + "_TOO_LARGE", "the drawing has more than 16 MiB when decompressed", field);
    }
    if (state == Z_STREAM_END) {
      const bool more = is_gzip({reinterpret_cast<const char*>(stream.next_in), stream.avail_in});
      if (!more) return text;
      if (inflateReset(&stream) != Z_OK) return broken;
    } else if (state != Z_OK) {
      return broken;
    }
  }
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
