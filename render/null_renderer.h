#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/renderer.h"

namespace kerf::render {

// Returns a renderer that refuses every picture with `reason`, a sentence for people, without a full stop. `outcomes`:
// one for each device tried; devices() returns them.
std::unique_ptr<Renderer> make_null_renderer(const std::string& reason, std::vector<DeviceOutcome> outcomes = {});

}  // namespace kerf::render
