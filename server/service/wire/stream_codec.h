#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "server/core/sheet/snapshot.h"

namespace kerf::v1 {
class Ended;
class FrameStats;
class Image;
}  // namespace kerf::v1

// Encodes the parts common to streams of frames and of images, and the messages of image streams.
namespace kerf::wire {

// Encodes all fields of FrameStats except `skipped`.
void encode_stats(const sheet::RunStats& stats, const sheet::Topology& topology, v1::FrameStats& message);

enum class EndReason { kSheetDeleted, kSheetLost, kServerStopping, kTooSlow };
void encode_end(EndReason reason, v1::Ended& message);

// Returns the start of a serialised message with only the length-delimited field `number`, of which `bytes` bytes
// follow.
std::string begin_field(int number, std::size_t bytes);

// Returns a serialised WatchImagesResponse without its last `data_bytes` > 0 bytes, those of the picture, so that many
// streams send the same bytes. `image`: everything except data.
std::string encode_image_head(const v1::Image& image, std::size_t data_bytes);
// Returns a complete serialised WatchImagesResponse.
std::string encode_images_ended(EndReason reason);

}  // namespace kerf::wire
