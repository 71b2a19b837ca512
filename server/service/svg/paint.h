#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/service/drawing/colour.h"
#include "server/service/drawing/dash.h"
#include "server/service/svg/attributes.h"
#include "server/service/svg/css_match.h"

namespace kerf::svg {

// The value of `fill` or `stroke`.
struct Paint {
  enum class Kind { kNone, kColour, kCurrentColour, kOther };  // kOther: a gradient or a pattern.
  Kind kind = Kind::kNone;
  drawing::Colour colour;
};

// Holds what an element inherits and passes on. Lengths stay text until a shape knows its viewport.
struct Style {
  bool is_shown = true;  // Neither it nor what it is in has display: none or no opacity.
  bool is_visible = true;
  drawing::Colour colour;
  Paint fill{Paint::Kind::kColour, {}};
  Paint stroke;
  bool has_stroke = false;  // Some element around it, or it, sets `stroke`.
  double fill_opacity = 1.0;
  double stroke_opacity = 1.0;
  std::string stroke_width = "1";
  std::string dash_array = "none";
  std::string dash_offset = "0";
};

// Applies an element's own properties to what it inherits. Values that cannot be read change nothing.
void apply(const Declared& declared, Style& style);

// True for a paint that CSS may know, such as oklch(...), but whose colour is not read here.
bool is_unread_colour(const std::string& value);
// True for a list of dashes that cannot be read.
bool is_unread_dashes(const std::string& value);

// Tells what is seen of a shape.
struct Seen {
  bool is_painted = true;
  std::optional<std::uint32_t> stroke;  // 0xrrggbb; absent: it has none, or no single colour.
  std::optional<std::uint32_t> fill;    // 0xrrggbb
};
Seen seen(const Style& style, const Viewport& viewport);

// Returns the dashes of a shape in user units, or nothing if its outline is cut whole. A shape on which `stroke` was
// never set has its dashes, too.
std::optional<drawing::Dashes> dashes_of(const Style& style, const Viewport& viewport);

}  // namespace kerf::svg
