#pragma once

#include <string>
#include <string_view>

#include <pugixml.hpp>

#include "server/service/svg/attributes.h"
#include "server/service/svg/css_match.h"
#include "server/service/svg/path_data.h"

namespace kerf::svg {

// True for path, rect, circle, ellipse, line, polyline and polygon.
bool is_shape(std::string_view element);

// Returns the outline of a shape in its own coordinates, as defined by SVG 1.1, chapters 8 and 9. It is empty if a side
// or a radius is not above zero. Percentages refer to the viewport.
// Sizes and places are those of its style or attributes.
PathData outline_of(const pugi::xml_node& node, std::string_view element, const Declared& declared,
                    const Viewport& viewport, std::size_t max_segments);

}  // namespace kerf::svg
