#pragma once

#include <string>
#include <vector>

#include <pugixml.hpp>

namespace kerf::svg {

// True for a group that Inkscape calls a layer.
bool is_inkscape_layer(const pugi::xml_node& node);

// Returns the names of the layer that an element is; none if it is no layer. In a drawing of Inkscape these are its
// layers' labels. Otherwise groups directly in the drawing are layers, under their ids and the names that Illustrator
// and Figma encode in them.
std::vector<std::string> layer_names(const pugi::xml_node& node, const pugi::xml_node& root, bool has_inkscape_layers);

}  // namespace kerf::svg
