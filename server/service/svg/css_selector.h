#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "server/service/svg/css.h"

namespace kerf::svg {

// Parses a list of selectors. Returns nothing if one of them is malformed, since its whole rule is then left out. Tests
// that a drawing cannot pass, such as :hover, are no fault.
std::optional<std::vector<Selector>> parse_selectors(std::string_view text);

}  // namespace kerf::svg
