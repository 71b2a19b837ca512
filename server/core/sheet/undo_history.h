#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/base/result.h"
#include "server/core/sheet/done_cut.h"

namespace kerf::sheet {

struct Checkpoint;

// Holds what one UndoCut undoes: the applied cuts of a Cut or CutBatch, in the order of their making, or a Reset. Never
// changes.
struct UndoStep {
  std::vector<DoneCut> cuts;
  std::shared_ptr<const Checkpoint> before_reset;  // null: a step of cuts
  std::int64_t beginning = 0;                      // of a Reset: the number that it gave, see CommandReply
  std::size_t bytes = 0;                           // of memory, approximately
};

// Steps done and steps undone. Bounded: the oldest steps done are forgotten first. A plain value that is cheap to copy.
class UndoHistory {
 public:
  static constexpr std::size_t kMaxSteps = 1000;                   // that can be undone
  static constexpr std::size_t kMaxBytes = std::size_t{32} << 20;  // of the steps done and those undone together

  // Adds a new cut, after which nothing can be redone. A step that alone is beyond kMaxBytes is forgotten at once, and
  // with it all steps before it.
  void add(std::vector<DoneCut> cuts);
  // Adds a new Reset; the same holds.
  void add_reset(std::shared_ptr<const Checkpoint> before, std::int64_t beginning);
  // Adds a Reset, taken from the undone steps, that was done again from `before`.
  void redo_reset(std::shared_ptr<const Checkpoint> before);
  void clear();

  // Errors: kFailedPrecondition NOTHING_TO_UNDO, UNDO_FORGOTTEN.
  Result<std::shared_ptr<const UndoStep>> take_done();
  // Error: kFailedPrecondition NOTHING_TO_REDO.
  Result<std::shared_ptr<const UndoStep>> take_undone();

  [[nodiscard]] std::size_t num_done() const { return done_.size(); }
  [[nodiscard]] std::size_t num_undone() const { return undone_.size(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  using Steps = std::vector<std::shared_ptr<const UndoStep>>;

  void keep(UndoStep step);

  Steps done_;    // oldest first
  Steps undone_;  // that undone last at the end
  std::size_t bytes_ = 0;
  bool forgotten_ = false;  // a step before done_ was dropped
};

}  // namespace kerf::sheet
