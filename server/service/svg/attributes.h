#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <pugixml.hpp>

namespace kerf::svg {

// A property by its declaration in the `style` attribute, else by the attribute of its name; blanks around it removed,
// empty where there is neither.
std::string property(const pugi::xml_node& node, std::string_view name);

// What percentages refer to: the sides of the nearest viewport, in user units.
struct Viewport {
  Eigen::Vector2d size{0.0, 0.0};

  [[nodiscard]] double width() const { return size.x(); }
  [[nodiscard]] double height() const { return size.y(); }
  [[nodiscard]] double diagonal() const { return size.norm() / 1.4142135623730951; }  // SVG 1.1, section 7.10
};

// A length in user units: px or no unit, mm, cm, in, pt, pc, Q, em and ex of a 16 px font, and % of `whole`. Nothing
// where it cannot be read.
std::optional<double> parse_length(std::string_view text, double whole);

// The same of an attribute: `otherwise` where it is missing, "auto" or cannot be read.
double length_of(const pugi::xml_node& node, const char* name, double whole, double otherwise);

}  // namespace kerf::svg
