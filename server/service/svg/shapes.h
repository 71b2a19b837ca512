#pragma once

#include <string>
#include <string_view>

#include <pugixml.hpp>

#include "server/service/svg/attributes.h"
#include "server/service/svg/path_data.h"

namespace kerf::svg {

// path, rect, circle, ellipse, line, polyline and polygon.
bool is_shape(std::string_view element);

// The outline of a shape in its own coordinates, as SVG 1.1, chapters 8 and 9, have it; empty where a side or a radius
// is not above zero. Percentages refer to the viewport.
PathData outline_of(const pugi::xml_node& node, std::string_view element, const Viewport& viewport,
                    std::size_t max_segments);

}  // namespace kerf::svg
