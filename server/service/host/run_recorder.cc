#include "server/service/host/run_recorder.h"

namespace kerf::host {

void RunRecorder::begin(std::shared_ptr<sheet::RecordingSink> sink, const scene::SheetConfig& config) {
  sink_ = std::move(sink);
  if (sink_) sink_->start(config);
}

void RunRecorder::settle(bool was_apply) {
  if (bare_ && was_apply) kept_.append(*bare_);
  bare_.reset();
}

void RunRecorder::replace(KeptEntries kept, const std::string& why) {
  kept_.replace(std::move(kept));
  bare_.reset();
  if (sink_) sink_->end_early(why);
  sink_.reset();
}

}  // namespace kerf::host
