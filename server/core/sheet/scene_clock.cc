#include "server/core/sheet/scene_clock.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kerf::sheet {

SceneClock::SceneClock(std::shared_ptr<const scene::SheetConfig> config)
    : config_(std::move(config)), schedule_(config_->commands.size()), dt_(1.0 / config_->tick_rate_hz) {
  const std::vector<scene::ScheduledCommand>& commands = config_->commands;
  std::iota(schedule_.begin(), schedule_.end(), std::size_t{0});
  std::stable_sort(schedule_.begin(), schedule_.end(),
                   [&](std::size_t a, std::size_t b) { return commands[a].tick < commands[b].tick; });
}

std::optional<std::size_t> SceneClock::pop_due() {
  if (is_exhausted()) return std::nullopt;
  const std::size_t index = schedule_[schedule_place_.next];
  if (config_->commands[index].tick > tick_ + 1 - schedule_place_.start_tick) return std::nullopt;
  ++schedule_place_.next;
  return index;
}

ScenePlace SceneClock::save() const {
  return {scene_tick(), {schedule_place_.start_tick - tick_, schedule_place_.next}};
}

void SceneClock::restore(const ScenePlace& place) {
  start_tick_ = tick_ - place.scene_tick;
  schedule_place_ = {tick_ + place.schedule.start_tick, place.schedule.next};
}

}  // namespace kerf::sheet
