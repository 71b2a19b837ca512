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

}  // namespace kerf::host
