#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// Colours as CSS writes them.
namespace kerf::drawing {

struct Colour {
  std::uint32_t rgb = 0;  // 0xrrggbb
  double alpha = 1.0;     // -, 0..1; 0 paints nothing
};

// Parses a CSS colour: a name, #rgb, #rgba, #rrggbb, #rrggbbaa, rgb(), rgba(), hsl() or hsla(), with commas or blanks.
// Returns nothing if the text is no colour. `currentColor` is none here.
std::optional<Colour> parse_colour(std::string_view text);

// Returns the CSS name of a colour if it has one, else "#rrggbb".
std::string name_of_colour(std::uint32_t rgb);

}  // namespace kerf::drawing
