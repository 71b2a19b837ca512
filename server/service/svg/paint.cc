#include "server/service/svg/paint.h"

#include <algorithm>
#include <array>

#include "server/service/svg/css_scanner.h"
#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

bool is_inherited(const std::string& keyword) {
  return keyword.empty() || keyword == "inherit" || keyword == "unset" || keyword == "revert";
}

// True for one of the functions that make a colour.
bool is_function(const std::string& keyword) {
  constexpr std::array<std::string_view, 9> kFunctions{"hwb(",   "lab(",       "lch(",        "oklab(",      "oklch(",
                                                       "color(", "color-mix(", "light-dark(", "device-cmyk("};
  return std::any_of(kFunctions.begin(), kFunctions.end(),
                     [&keyword](std::string_view each) { return keyword.starts_with(each); });
}

// Parses a paint; returns nothing if it is malformed.
std::optional<Paint> parse_paint(const std::string& value) {
  const std::string keyword = lower(value);
  if (keyword == "none") return Paint{};
  if (keyword == "currentcolor") return Paint{Paint::Kind::kCurrentColour, {}};
  if (keyword.compare(0, 4, "url(") == 0 || keyword.compare(0, 8, "context-") == 0) {
    return Paint{Paint::Kind::kOther, {}};
  }
  const std::optional<drawing::Colour> colour =
      drawing::parse_colour(std::string_view(value).substr(0, keyword.find(" icc-color")));
  if (!colour && is_function(keyword)) return Paint{Paint::Kind::kOther, {}};
  return colour ? std::optional(Paint{Paint::Kind::kColour, *colour}) : std::nullopt;
}

void set_paint(const std::string& value, const Paint& initial, Paint& paint) {
  const std::string keyword = lower(value);
  if (is_inherited(keyword)) return;
  if (keyword == "initial") {
    paint = initial;
  } else if (const std::optional<Paint> parsed = parse_paint(value)) {
    paint = *parsed;
  }
}

std::optional<double> parse_share(const std::string& value) {
  const std::optional<double> share = parse_length(value, 1.0);
  return share ? std::optional(std::clamp(*share, 0.0, 1.0)) : std::nullopt;
}

void set_share(const std::string& value, double& share) {
  if (lower(value) == "initial") {
    share = 1.0;
  } else if (const std::optional<double> parsed = parse_share(value)) {
    share = *parsed;
  }
}

void set_text(const std::string& value, const char* initial, std::string& text) {
  const std::string keyword = lower(value);
  if (is_inherited(keyword)) return;
  text = keyword == "initial" ? initial : value;
}

bool paints(const Paint& paint, const drawing::Colour& current, double opacity) {
  if (paint.kind == Paint::Kind::kNone) return false;
  const double alpha = paint.kind == Paint::Kind::kColour          ? paint.colour.alpha
                       : paint.kind == Paint::Kind::kCurrentColour ? current.alpha
                                                                   : 1.0;
  return alpha * opacity > 0.0;
}

std::optional<std::uint32_t> colour_of(const Paint& paint, const drawing::Colour& current) {
  if (paint.kind == Paint::Kind::kColour) return paint.colour.rgb;
  if (paint.kind == Paint::Kind::kCurrentColour) return current.rgb;
  return std::nullopt;
}

bool strokes(const Style& style, const Viewport& viewport) {
  const double width = parse_length(style.stroke_width, viewport.diagonal()).value_or(1.0);
  return width > 0.0 && paints(style.stroke, style.colour, style.stroke_opacity);
}

}  // namespace

void apply(const Declared& declared, Style& style) {
  const auto keyword = [&declared](Property property) { return lower(declared[property]); };
  if (keyword(Property::kDisplay) == "none") style.is_shown = false;
  const std::string opacity = keyword(Property::kOpacity);
  if (!opacity.empty() && parse_share(opacity) == 0.0) style.is_shown = false;
  const std::string visibility = keyword(Property::kVisibility);
  if (visibility == "visible" || visibility == "initial") style.is_visible = true;
  if (visibility == "hidden" || visibility == "collapse") style.is_visible = false;
  if (keyword(Property::kColour) == "initial") {
    style.colour = {};
  } else if (const std::optional<drawing::Colour> colour = drawing::parse_colour(declared[Property::kColour])) {
    style.colour = *colour;
  }
  set_paint(declared[Property::kFill], {Paint::Kind::kColour, {}}, style.fill);
  set_paint(declared[Property::kStroke], {}, style.stroke);
  style.has_stroke = style.has_stroke || !is_inherited(keyword(Property::kStroke));
  set_share(declared[Property::kFillOpacity], style.fill_opacity);
  set_share(declared[Property::kStrokeOpacity], style.stroke_opacity);
  set_text(declared[Property::kStrokeWidth], "1", style.stroke_width);
  set_text(declared[Property::kDashArray], "none", style.dash_array);
  set_text(declared[Property::kDashOffset], "0", style.dash_offset);
}

bool is_unread_colour(const std::string& value) {
  return is_function(lower(value)) && !drawing::parse_colour(value);
}

bool is_unread_dashes(const std::string& value) {
  return value.find('(') != std::string::npos;
}

Seen seen(const Style& style, const Viewport& viewport) {
  Seen result;
  const bool is_filled = paints(style.fill, style.colour, style.fill_opacity);
  const bool is_stroked = strokes(style, viewport);
  result.is_painted = style.is_shown && style.is_visible && (is_filled || is_stroked);
  if (is_stroked) result.stroke = colour_of(style.stroke, style.colour);
  if (is_filled) result.fill = colour_of(style.fill, style.colour);
  return result;
}

std::optional<drawing::Dashes> dashes_of(const Style& style, const Viewport& viewport) {
  if (lower(style.dash_array) == "none" || (style.has_stroke && !strokes(style, viewport))) return std::nullopt;
  drawing::Dashes dashes;
  double total = 0.0;
  std::string_view rest = trimmed(style.dash_array);
  while (!rest.empty()) {
    const std::size_t end = rest.find_first_of(", \t\n\r\f");
    const std::optional<double> length = parse_length(rest.substr(0, end), viewport.diagonal());
    if (!length || *length < 0.0) return std::nullopt;  // A malformed list draws solid lines.
    dashes.lengths.push_back(*length);
    total += *length;
    rest = end == std::string_view::npos ? std::string_view() : trimmed(rest.substr(end));
    if (!rest.empty() && rest.front() == ',') rest = trimmed(rest.substr(1));
  }
  if (!(total > 0.0)) return std::nullopt;
  dashes.offset = parse_length(style.dash_offset, viewport.diagonal()).value_or(0.0);
  return dashes;
}

}  // namespace kerf::svg
