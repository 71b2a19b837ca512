#include "server/core/sheet/undo_history.h"

#include <utility>

#include "server/core/sheet/checkpoint.h"

namespace kerf::sheet {

namespace {

Error nothing(const char* reason, const char* message) {
  return failed_precondition(reason, message);
}

}  // namespace

std::size_t bytes_of(const UndoStep& step) {
  std::size_t bytes = step.before_reset ? bytes_of(*step.before_reset) : 0;
  for (const DoneCut& cut : step.cuts) bytes += bytes_of(cut);
  return bytes;
}

void UndoHistory::add(std::vector<DoneCut> cuts) {
  for (const auto& step : undone_) bytes_ -= step->bytes;
  undone_.clear();
  UndoStep step;
  step.cuts = std::move(cuts);
  keep(std::move(step));
}

void UndoHistory::add_reset(std::shared_ptr<const Checkpoint> before, std::int64_t beginning) {
  for (const auto& step : undone_) bytes_ -= step->bytes;
  undone_.clear();
  UndoStep step;
  step.before_reset = std::move(before);
  step.beginning = beginning;
  keep(std::move(step));
}

void UndoHistory::redo_reset(std::shared_ptr<const Checkpoint> before) {
  UndoStep step = *done_.back();
  bytes_ -= step.bytes;
  done_.pop_back();
  step.before_reset = std::move(before);
  keep(std::move(step));
}

void UndoHistory::keep(UndoStep step) {
  step.bytes = bytes_of(step);
  bytes_ += step.bytes;
  done_.push_back(std::make_shared<const UndoStep>(std::move(step)));
  while (!done_.empty() && (done_.size() > kMaxSteps || bytes_ > kMaxBytes)) {
    bytes_ -= done_.front()->bytes;
    done_.erase(done_.begin());
    forgotten_ = true;
  }
}

void UndoHistory::clear() {
  *this = UndoHistory();
}

Result<std::shared_ptr<const UndoStep>> UndoHistory::take_done() {
  if (done_.empty() && forgotten_) {
    return nothing("UNDO_FORGOTTEN",
                   "earlier steps are no longer kept: undo keeps at most 1000 steps and 32 MiB; reset the sheet to "
                   "return to its beginning");
  }
  if (done_.empty()) return nothing("NOTHING_TO_UNDO", "the sheet has no cut and no reset to undo");
  undone_.push_back(std::move(done_.back()));
  done_.pop_back();
  return undone_.back();
}

Result<std::shared_ptr<const UndoStep>> UndoHistory::take_undone() {
  if (undone_.empty()) {
    return nothing("NOTHING_TO_REDO",
                   "nothing has been undone since the last cut or reset, so there is nothing to redo");
  }
  done_.push_back(std::move(undone_.back()));
  undone_.pop_back();
  return done_.back();
}

}  // namespace kerf::sheet
