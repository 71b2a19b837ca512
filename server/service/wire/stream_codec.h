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

// What streams of frames and streams of images have in common, and the messages of the latter.
namespace kerf::wire {

// All but `skipped`.
void encode_stats(const sheet::RunStats& stats, const sheet::Topology& topology, v1::FrameStats& message);

enum class EndReason { kSheetDeleted, kSheetLost, kServerStopping, kTooSlow };
void encode_end(EndReason reason, v1::Ended& message);

// The start of a serialised message with nothing but the length-delimited field `number`, of which `bytes` bytes
// follow.
std::string begin_field(int number, std::size_t bytes);

// A serialised WatchImagesResponse but for the last bytes of it, which are the picture's: `data_bytes` of them, > 0, so
// that many streams send the same bytes. `image`: everything but data.
std::string encode_image_head(const v1::Image& image, std::size_t data_bytes);
// A whole serialised WatchImagesResponse.
std::string encode_images_ended(EndReason reason);

}  // namespace kerf::wire
