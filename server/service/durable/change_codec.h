#pragma once

#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/host/sheet_event.h"

namespace kerf::v1 {
class ScheduledChange;
}  // namespace kerf::v1

// Encodes what a journal keeps of sheets: kerf.v1.StoredChange, and the header of a recording for a scene.
namespace kerf::durable {

std::string encode_change(const host::SheetEvent& event);
// kDataLoss CHANGE_DAMAGED for other bytes than those of encode_change().
Result<host::SheetEvent> decode_change(std::string_view bytes);

v1::ScheduledChange encode_scheduled(const host::ScheduledCommand& scheduled);
// kDataLoss CHANGE_DAMAGED
Result<host::ScheduledCommand> decode_scheduled(const v1::ScheduledChange& message);

std::string encode_stored_scene(const scene::SheetConfig& config);
// Errors of wire::decode_recording().
Result<scene::SheetConfig> decode_stored_scene(std::string_view bytes);

}  // namespace kerf::durable
