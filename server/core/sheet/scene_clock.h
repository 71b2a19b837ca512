#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "server/core/scene/sheet_config.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// Progress of a sheet through the scheduled commands of its scene.
struct SchedulePlace {
  std::int64_t start_tick = 0;  // tick of the sheet from which the ticks of commands count
  std::size_t next = 0;         // number of commands already passed, in the order of their ticks
};

// A place in the scene, relative to the present tick.
struct ScenePlace {
  std::int64_t scene_tick = 0;  // ticks since the scene began
  SchedulePlace schedule{};     // its start_tick is relative to the present tick, <= 0
};

// Counts the ticks of a sheet and of its scene, and returns scheduled commands when they are due. The tick of the sheet
// never decreases; restore() only sets the place in the scene.
class SceneClock {
 public:
  explicit SceneClock(std::shared_ptr<const scene::SheetConfig> config);

  [[nodiscard]] double dt() const { return dt_; }            // s
  [[nodiscard]] std::int64_t tick() const { return tick_; }  // number of ticks made
  [[nodiscard]] std::int64_t scene_tick() const { return tick_ - start_tick_; }
  // Returns the scene's time (s) at the end of the next tick.
  [[nodiscard]] double end_of_next_tick() const { return static_cast<double>(tick_ + 1 - start_tick_) * dt_; }
  void advance() { ++tick_; }

  // Returns the next command that is due in the next tick, as index into SheetConfig::commands, and moves past it.
  // Commands come in the order of their ticks, those of one tick in the order of the config.
  std::optional<std::size_t> pop_due();
  // Returns true if all scheduled commands have been returned.
  [[nodiscard]] bool is_exhausted() const { return schedule_place_.next == schedule_.size(); }
  [[nodiscard]] const SchedulePlace& schedule_place() const { return schedule_place_; }
  void set_schedule_place(const SchedulePlace& place) { schedule_place_ = place; }

  [[nodiscard]] ScenePlace save() const;
  void restore(const ScenePlace& place);

 private:
  friend struct Fields<SceneClock>;
  std::shared_ptr<const scene::SheetConfig> config_;
  std::vector<std::size_t> schedule_;  // indices into config_->commands, sorted by tick
  double dt_;                          // s
  std::int64_t tick_ = 0;
  std::int64_t start_tick_ = 0;  // tick of the sheet at which the scene began
  SchedulePlace schedule_place_;
};

}  // namespace kerf::sheet
