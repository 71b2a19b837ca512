#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "server/core/scene/sheet_config.h"

namespace kerf::sheet {

// Progress of a sheet through the commands of its scene.
struct SchedulePlace {
  std::int64_t start_tick = 0;  // from which their ticks count
  std::size_t next = 0;         // in their order
};

// A place in the scene that does not depend on the tick.
struct ScenePlace {
  std::int64_t scene_tick = 0;  // ticks since the scene began
  SchedulePlace schedule{};     // its start_tick counts from the present tick, <= 0
};

// Counts the ticks of a sheet and of its scene, and yields the scene's commands as they fall due. Ticks never count
// back; restore() sets only the place in the scene.
class SceneClock {
 public:
  explicit SceneClock(std::shared_ptr<const SheetConfig> config);

  [[nodiscard]] double dt() const { return dt_; }            // s
  [[nodiscard]] std::int64_t tick() const { return tick_; }  // ticks done
  [[nodiscard]] std::int64_t scene_tick() const { return tick_ - start_tick_; }
  // Returns the scene's time (s) at the end of the next tick.
  [[nodiscard]] double end_of_next_tick() const { return static_cast<double>(tick_ + 1 - start_tick_) * dt_; }
  void advance() { ++tick_; }

  // Returns the index into SheetConfig::commands of the next command due in the next tick, and moves past it. Commands
  // come by tick, those of one tick in the order of the config.
  std::optional<std::size_t> pop_due();
  // Returns true if no command of the scene is left.
  [[nodiscard]] bool is_exhausted() const { return schedule_place_.next == schedule_.size(); }
  [[nodiscard]] const SchedulePlace& schedule_place() const { return schedule_place_; }
  void set_schedule_place(const SchedulePlace& place) { schedule_place_ = place; }

  [[nodiscard]] ScenePlace save() const;
  void restore(const ScenePlace& place);

 private:
  std::shared_ptr<const SheetConfig> config_;
  std::vector<std::size_t> schedule_;  // indices of config_->commands, by tick
  double dt_;                          // s
  std::int64_t tick_ = 0;
  std::int64_t start_tick_ = 0;  // from which the scene's time counts
  SchedulePlace schedule_place_;
};

}  // namespace kerf::sheet
