#include "server/service/svg/svg.h"

#include <string>

#include <pugixml.hpp>

#include "server/service/drawing/inflate.h"
#include "server/service/svg/text.h"
#include "server/service/svg/walk.h"

namespace kerf::svg {
namespace {

constexpr const char* kField = "cut.curve.svg";

bool is_svg(const pugi::xml_node& node) {
  return local_name(node) == "svg";
}

Error malformed(const std::string& why) {
  return invalid_argument("SVG_MALFORMED", why, kField);
}

}  // namespace

Result<std::string> outline_text(std::string_view data) {
  if (data.size() > kMaxFileBytes) return invalid_argument("SVG_TOO_LARGE", "the drawing has more than 16 MiB", kField);
  std::string text;
  if (drawing::is_gzip(data)) {
    KERF_TRY_ASSIGN(const std::string unpacked, drawing::inflated(data, "SVG", kField));
    text = without_embedded_data(text_of(unpacked));
  } else {
    text = without_embedded_data(text_of(data));
  }
  if (text.size() <= kMaxTextBytes) return text;
  return invalid_argument("SVG_TOO_LARGE",
                          "the drawing has " + std::to_string(text.size()) +
                              " bytes without embedded pictures and fonts; the limit is 512 KiB",
                          kField);
}

Result<drawing::Drawing> read(std::string_view data, const ReadOptions& options) {
  KERF_TRY_ASSIGN(const std::string text, outline_text(data));
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    return malformed(std::string("not XML: ") + parsed.description() + " at byte " + std::to_string(parsed.offset));
  }
  const pugi::xml_node root = document.document_element();
  if (!is_svg(root)) return malformed(std::string("the root element is '") + root.name() + "'; it must be svg");
  Walk walk(root, options);
  if (text.find("<?xml-stylesheet") != std::string::npos) walk.report("external style sheet");
  KERF_TRY(walk.run());
  return walk.take_drawing();
}

}  // namespace kerf::svg
