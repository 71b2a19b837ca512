#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/base/result.h"
#include "server/core/fem/element/loads.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/scene/lineage.h"
#include "server/core/sheet/checkpoint.h"

namespace kerf::sheet {

// One applied cut: what it did, and all that taking it back and making it again needs.
struct DoneCut {
  mesh::CommittedEdit edit;
  mesh::UndoLog again;  // makes the edit again once it is undone: edit.undo.inverse()
  std::int64_t number = 0;
  LineageChange lineage;
  std::vector<fem::Pin> lost_pins;  // of vertices that it left without material
  std::int32_t pins_version = 0;    // Sheet::Impl::pins_version then: pins set since are not put back
};

// Holds what one UndoCut takes back: the applied cuts of a Cut or CutBatch, in the order of their making, or a Reset.
// Never changes.
struct UndoStep {
  std::vector<DoneCut> cuts;
  std::shared_ptr<const Checkpoint> before_reset;  // null: a step of cuts
  std::int64_t beginning = 0;                      // of a Reset: the number that it gave, see CommandReply
  std::size_t bytes = 0;                           // it takes about
};

// Steps done and steps undone. Bounded: the oldest steps done are forgotten first. A plain value that is cheap to copy.
class UndoHistory {
 public:
  static constexpr std::size_t kMaxSteps = 1000;                   // that can be undone
  static constexpr std::size_t kMaxBytes = std::size_t{32} << 20;  // of the steps done and those undone together

  // A new cut: nothing can be made again from here on. A step that alone is beyond kMaxBytes is forgotten at once, and
  // with it all before it.
  void add(std::vector<DoneCut> cuts);
  // A new Reset: the same holds.
  void add_reset(std::shared_ptr<const Checkpoint> before, std::int64_t beginning);
  // A Reset that was taken from those undone is done again from `before`.
  void redo_reset(std::shared_ptr<const Checkpoint> before);
  void clear();

  // kFailedPrecondition NOTHING_TO_UNDO, UNDO_FORGOTTEN.
  Result<std::shared_ptr<const UndoStep>> take_done();
  // kFailedPrecondition NOTHING_TO_REDO.
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
