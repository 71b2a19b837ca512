#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/base/result.h"
#include "server/core/sheet/done_cut.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

struct Checkpoint;

// The step that one UndoCut undoes: the applied cuts of a Cut or CutBatch, in order, or a Reset. Immutable.
struct UndoStep {
  std::vector<DoneCut> cuts;
  std::shared_ptr<const Checkpoint> before_reset;  // the state before the Reset; null if this is a step of cuts
  std::int64_t beginning = 0;                      // for a Reset: CommandReply::beginning after it
  std::size_t bytes = 0;                           // approximate memory
};

// Returns an estimate of the memory of a step, bytes. It depends on sizes alone, not on capacities.
std::size_t bytes_of(const UndoStep& step);

// The steps that can be undone ("done") and redone ("undone"). Their number and memory are limited: the oldest done
// steps are forgotten first. A plain value that is cheap to copy.
class UndoHistory {
 public:
  static constexpr std::size_t kMaxSteps = 1000;                   // most done steps
  static constexpr std::size_t kMaxBytes = std::size_t{32} << 20;  // most memory of done and undone steps together

  // Adds new cuts as one step, after which nothing can be redone. A step that needs more than kMaxBytes by itself is
  // forgotten at once, with all steps before it.
  void add(std::vector<DoneCut> cuts);
  // Adds a new Reset as a step, as add() does. `before`: the state before it.
  void add_reset(std::shared_ptr<const Checkpoint> before, std::int64_t beginning);
  // Must be called after take_undone() has returned a Reset that is done again: replaces its state before the Reset by
  // `before`.
  void redo_reset(std::shared_ptr<const Checkpoint> before);
  void clear();

  // Moves the last done step to the undone steps, and returns it. Errors: kFailedPrecondition NOTHING_TO_UNDO,
  // UNDO_FORGOTTEN.
  Result<std::shared_ptr<const UndoStep>> take_done();
  // Moves the step undone last back to the done steps, and returns it. Error: kFailedPrecondition NOTHING_TO_REDO.
  Result<std::shared_ptr<const UndoStep>> take_undone();

  [[nodiscard]] std::size_t num_done() const { return done_.size(); }
  [[nodiscard]] std::size_t num_undone() const { return undone_.size(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  friend struct Fields<UndoHistory>;
  using Steps = std::vector<std::shared_ptr<const UndoStep>>;

  void keep(UndoStep step);

  Steps done_;    // oldest first
  Steps undone_;  // the step undone last is at the end
  std::size_t bytes_ = 0;
  bool forgotten_ = false;  // true if a step older than done_ was forgotten
};

}  // namespace kerf::sheet
