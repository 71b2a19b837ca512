#include "server/service/wire/stream_codec.h"

#include "kerf/v1/render.pb.h"
#include "kerf/v1/stream.pb.h"

namespace kerf::wire {
namespace {

void append_varint(std::uint64_t value, std::string& bytes) {
  while (value >= 0x80) {
    bytes.push_back(static_cast<char>((value & 0x7f) | 0x80));
    value >>= 7;
  }
  bytes.push_back(static_cast<char>(value));
}

}  // namespace

void encode_stats(const sheet::RunStats& stats, const sheet::Topology& topology, v1::FrameStats& message) {
  message.set_real_time_factor(stats.real_time_factor);
  message.set_overruns(stats.overruns);
  message.set_speed(stats.speed);
  message.set_slipped_s(stats.slipped_s);
  message.set_tick_cpu_us(stats.tick_cpu_us);
  message.set_published_unix_us(stats.published_unix_us);
  message.set_pieces(topology.num_pieces);
  message.set_num_triangles(topology.num_triangles);
  message.set_settings_version(stats.settings_version);
  message.set_paused(stats.paused);
  message.set_sleeping(stats.sleeping);
  message.set_strained_share(static_cast<float>(stats.strained_share));
  message.set_intersections(stats.intersections);
  message.set_resets(stats.resets);
  message.set_resets_undone(stats.resets_undone);
  message.set_unconfirmed_ms(stats.unconfirmed_ms);
}

void encode_end(EndReason reason, v1::Ended& message) {
  switch (reason) {
    case EndReason::kSheetDeleted:
      message.set_reason(v1::Ended::SHEET_DELETED);
      message.set_message("the sheet was deleted");
      break;
    case EndReason::kSheetLost:
      message.set_reason(v1::Ended::SHEET_DELETED);
      message.set_message("the server had too little memory to keep the sheet; other sheets are unaffected");
      break;
    case EndReason::kServerStopping:
      message.set_reason(v1::Ended::SERVER_STOPPING);
      message.set_message("the server is stopping; connect again later");
      break;
    case EndReason::kTooSlow:
      message.set_reason(v1::Ended::TOO_SLOW);
      message.set_message("no frame was acknowledged for too long; acknowledge each one, or watch again later");
      break;
  }
}

std::string begin_field(int number, std::size_t bytes) {
  constexpr std::uint64_t kLengthDelimited = 2;
  std::string head;
  append_varint(static_cast<std::uint64_t>(number) << 3 | kLengthDelimited, head);
  append_varint(bytes, head);
  return head;
}

std::string encode_image_head(const v1::Image& image, std::size_t data_bytes) {
  const std::string fields = image.SerializeAsString() + begin_field(v1::Image::kDataFieldNumber, data_bytes);
  return begin_field(v1::WatchImagesResponse::kImageFieldNumber, fields.size() + data_bytes) + fields;
}

std::string encode_images_ended(EndReason reason) {
  v1::WatchImagesResponse response;
  encode_end(reason, *response.mutable_ended());
  return response.SerializeAsString();
}

}  // namespace kerf::wire
