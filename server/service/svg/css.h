#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Reads the part of CSS that decides what of a drawing is cut: rules, their selectors and a few properties.
namespace kerf::svg {

// Properties that are read, in the order of kPropertyNames.
enum class Property : std::uint8_t {
  kDisplay,
  kVisibility,
  kColour,
  kFill,
  kStroke,
  kOpacity,
  kFillOpacity,
  kStrokeOpacity,
  kStrokeWidth,
  kDashArray,
  kDashOffset,
  kVectorEffect,
  kTransform,
  kTransformOrigin,
  kTransformBox,
  kClipPath,
  kMask,
  kFilter,
  kMarker,
  kMarkerStart,
  kMarkerMid,
  kMarkerEnd,
  kX,
  kY,
  kWidth,
  kHeight,
  kCx,
  kCy,
  kR,
  kRx,
  kRy,
  kTranslate,  // This and the later ones are properties of style sheets alone, and no attributes.
  kRotate,
  kScale,
  kD,
  kOffsetPath,  // This and the later ones are only named in notes.
  kMaskImage,
  kZoom,
};
inline constexpr std::size_t kNumProperties = 38;
inline constexpr std::array<std::string_view, kNumProperties> kPropertyNames{"display",
                                                                             "visibility",
                                                                             "color",
                                                                             "fill",
                                                                             "stroke",
                                                                             "opacity",
                                                                             "fill-opacity",
                                                                             "stroke-opacity",
                                                                             "stroke-width",
                                                                             "stroke-dasharray",
                                                                             "stroke-dashoffset",
                                                                             "vector-effect",
                                                                             "transform",
                                                                             "transform-origin",
                                                                             "transform-box",
                                                                             "clip-path",
                                                                             "mask",
                                                                             "filter",
                                                                             "marker",
                                                                             "marker-start",
                                                                             "marker-mid",
                                                                             "marker-end",
                                                                             "x",
                                                                             "y",
                                                                             "width",
                                                                             "height",
                                                                             "cx",
                                                                             "cy",
                                                                             "r",
                                                                             "rx",
                                                                             "ry",
                                                                             "translate",
                                                                             "rotate",
                                                                             "scale",
                                                                             "d",
                                                                             "offset-path",
                                                                             "mask-image",
                                                                             "zoom"};

std::optional<Property> property_named(std::string_view name);

struct Declaration {
  Property property = Property::kDisplay;
  std::string value;
  bool important = false;
  std::string custom = {};  // Name of a custom property, such as "--line"; `property` then means nothing.
};

// Returns the declarations of a style attribute or of a rule's block without nested rules. Unknown properties and
// malformed declarations are passed over, as CSS demands.
std::vector<Declaration> parse_declarations(std::string_view text);

struct AttributeTest {
  std::string name;
  char operation = '\0';  // '=', '~', '|', '^', '$', '*', or '\0' if the attribute only has to be there.
  std::string value;
};

struct Compound;

// A test of an element's place among its siblings: it is a n + b for some n >= 0.
struct PlaceTest {
  int a = 0;
  int b = 1;
  bool of_type = false;
  bool from_end = false;
};

// Tests that one element has to pass.
struct Compound {
  char combinator = '\0';  // To the compound before it: ' ', '>', '+' or '~'.
  std::string type;        // Empty: any element.
  std::string id;          // Empty: any.
  std::vector<std::string> classes;
  std::vector<AttributeTest> attributes;
  std::vector<PlaceTest> places;
  std::vector<std::vector<Compound>> any_of;   // Each list has one that passes.
  std::vector<std::vector<Compound>> none_of;  // No list has one that passes.
  bool is_root = false;
  bool never = false;   // It has a test that is never passed here, such as :hover.
  bool unread = false;  // It has a test that is not understood. It is never passed, either.
};

inline constexpr std::uint32_t kNoLayer = 0xffffffffU;

struct Selector {
  std::vector<Compound> compounds;  // From left to right; at least one.
  std::uint32_t specificity = 0;    // Ids, classes and types, ten bits each.
  std::size_t rule = 0;
  std::uint32_t layer = kNoLayer;  // Place of its @layer among the layers.
};

struct StyleRules {
  std::vector<Selector> selectors;
  std::vector<std::vector<Declaration>> rules;  // In the order of the text.
  std::vector<std::string> layers;              // Names of @layer, in the order of their first mention.
  int imports = 0;                              // Other sheets that the text asks for; none is read.
  int unread = 0;                               // Rules whose selector or condition is not understood.
  bool too_many = false;                        // The text has more than kMaxCssSelectors.
};

// Longer values are passed over, other than transforms in attributes and the data of paths.
inline constexpr std::size_t kMaxCssValue = 2'048;
inline constexpr std::size_t kMaxCssSelectors = 20'000;

// Adds the rules of a style sheet's text to `rules`. Rules that apply to media other than a light screen are left out.
void parse_style_sheet(std::string_view text, StyleRules& rules);

// Returns true if a media query list, as in @media and in the attribute `media`, applies to a light screen.
bool applies_to_screen(std::string_view media);

}  // namespace kerf::svg
