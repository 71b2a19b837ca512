#pragma once

#include <cstdint>

#include "server/core/sheet/stage_observer.h"

namespace kerf::sheet {

// The observer of a command's stages, and the command's number as in StageObserver::begin().
struct CommandContext {
  StageObserver* observer = nullptr;
  std::int32_t index = -1;
};

// Reports a stage to an observer, if there is one: its constructor the beginning, its destructor the end.
class StageScope {
 public:
  StageScope(Stage stage, const CommandContext& context) : stage_(stage), context_(context) {
    if (context_.observer != nullptr) context_.observer->begin(stage_, context_.index);
  }
  ~StageScope() {
    if (context_.observer != nullptr) context_.observer->end(stage_, context_.index);
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  Stage stage_;
  CommandContext context_;
};

}  // namespace kerf::sheet
