#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/renderer.h"

namespace kerf::render {

// Refuses every picture with `reason`, a sentence for people without a full stop. `outcomes`: what became of the
// devices that were looked at.
std::unique_ptr<Renderer> make_null_renderer(const std::string& reason, std::vector<DeviceOutcome> outcomes = {});

}  // namespace kerf::render
