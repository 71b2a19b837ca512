#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>
#include <pugixml.hpp>

namespace kerf::svg {

// Holds the sides of the nearest viewport, in user units. Percentages refer to these.
struct Viewport {
  Eigen::Vector2d size{0.0, 0.0};

  [[nodiscard]] double width() const { return size.x(); }
  [[nodiscard]] double height() const { return size.y(); }
  [[nodiscard]] double diagonal() const { return size.norm() / 1.4142135623730951; }  // SVG 1.1, section 7.10
};

// Parses a length and returns it in user units. Units, in any case: px or none, mm, cm, in, pt, pc, Q; em, rem, ex
// and ch of a 16 px font; and % of `whole`. Returns nothing if the text cannot be parsed.
std::optional<double> parse_length(std::string_view text, double whole);

// Parses an attribute as parse_length() does. Returns `otherwise` if it is missing, "auto" or malformed.
double length_of(const pugi::xml_node& node, const char* name, double whole, double otherwise);

}  // namespace kerf::svg
