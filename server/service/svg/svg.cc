#include "server/service/svg/svg.h"

#include <pugixml.hpp>

#include "server/service/svg/walk.h"

namespace kerf::svg {
namespace {

constexpr double kPixelM = 0.0254 / 96.0;
constexpr const char* kField = "cut.curve.svg";

bool is_svg(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return name.substr(colon == std::string_view::npos ? 0 : colon + 1) == "svg";
}

Error malformed(const std::string& why) {
  return invalid_argument("SVG_MALFORMED", why, kField);
}

}  // namespace

Result<Drawing> read(std::string_view text) {
  if (text.size() > kMaxTextBytes) {
    return invalid_argument("SVG_TOO_LARGE",
                            "the drawing has " + std::to_string(text.size()) + " bytes; the limit is 512 KiB", kField);
  }
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed) {
    return malformed(std::string("not XML: ") + parsed.description() + " at byte " + std::to_string(parsed.offset));
  }
  const pugi::xml_node root = document.document_element();
  if (!is_svg(root)) return malformed(std::string("the root element is '") + root.name() + "'; it must be svg");

  Affine to_sheet;
  to_sheet.linear = Eigen::Vector2d(kPixelM, -kPixelM).asDiagonal();
  Walk walk(root, to_sheet);
  KERF_TRY(walk.run());
  Drawing drawing{walk.take_path(), walk.not_cut()};
  if (drawing.path.subpaths.empty()) {
    std::string why = "there is no outline to cut in the drawing";
    for (const std::string& line : drawing.not_cut) why += "; " + line;
    return invalid_argument("SVG_EMPTY", why, kField);
  }
  if (const Status status = cut::validate(drawing.path); !status.ok()) {
    Error error = status.error();
    error.field = kField;
    return error;
  }
  return drawing;
}

}  // namespace kerf::svg
