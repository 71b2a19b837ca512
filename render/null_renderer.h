#pragma once

#include <memory>
#include <string>

#include "render/renderer.h"

namespace kerf::render {

// Refuses every picture with `reason`, a sentence for people without a full stop.
std::unique_ptr<Renderer> make_null_renderer(const std::string& reason);

}  // namespace kerf::render
