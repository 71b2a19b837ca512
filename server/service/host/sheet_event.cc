#include "server/service/host/sheet_event.h"

#include <algorithm>

namespace kerf::host {

namespace {

bool is_by_hand(const scene::Command& command) {
  return std::holds_alternative<scene::Grab>(command) || std::holds_alternative<scene::Drag>(command) ||
         std::holds_alternative<scene::Release>(command);
}

}  // namespace

bool is_edit(const SheetEvent& event) {
  const auto* tick = std::get_if<TickEvent>(&event);
  return tick == nullptr || !std::all_of(tick->commands.begin(), tick->commands.end(), is_by_hand);
}

}  // namespace kerf::host
