#pragma once

#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::svg {

// Replaces references to the entities that the document type declares, as Illustrator writes them: `style="&st0;"`.
// Entities within entities are replaced, too, up to a depth; external ones stay as they are. Error: SVG_TOO_LARGE if
// the result's bytes and the references replaced are more than `max_bytes` together.
Result<std::string> with_entities(std::string text, std::size_t max_bytes);

}  // namespace kerf::svg
