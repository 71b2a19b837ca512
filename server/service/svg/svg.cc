#include "server/service/svg/svg.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include <pugixml.hpp>

#include "server/base/text_encoding.h"
#include "server/service/drawing/inflate.h"
#include "server/service/svg/entities.h"
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

// Returns the bytes of the document, unpacked.
Result<std::string> unpacked(std::string_view data) {
  if (data.size() > kMaxFileBytes) return invalid_argument("SVG_TOO_LARGE", "the drawing has more than 16 MiB", kField);
  if (!drawing::is_gzip(data)) return std::string(data);
  return drawing::inflated(data, "SVG", kField);
}

pugi::xml_parse_result parse(const std::string& text, pugi::xml_document& document) {
  return document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
}

// Says what a text is that has no XML in it; empty if it may be meant as XML. Bytes beyond ASCII are UTF-8 here.
std::string what_instead(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return "the file is empty";
  text.remove_prefix(first);
  if (text.front() == '<') return {};
  if (text.starts_with("0\n") || text.starts_with("0\r") || text.starts_with("999")) {
    return "the file is DXF, and this reads SVG";
  }
  struct Kind {
    std::string_view start;
    std::string_view name;
  };
  constexpr std::array<Kind, 10> kKinds{{{"%PDF", "a PDF"},
                                         {"%!PS", "PostScript"},
                                         {"\xc2\x89PNG", "a picture (PNG)"},
                                         {"\xc3\xbf\xc3\x98", "a picture (JPEG)"},
                                         {"PK\x03\x04", "a ZIP archive"},
                                         {"ply", "a mesh (PLY)"},
                                         {"solid", "a mesh (STL)"},
                                         {"v ", "a mesh (OBJ)"},
                                         {"{", "JSON"},
                                         {"glTF", "a mesh (glTF)"}}};
  for (const auto& [start, name] : kKinds) {
    if (text.starts_with(start)) return "the file is " + std::string(name) + "; a drawing is SVG or DXF";
  }
  std::string line(text.substr(0, std::min(text.find_first_of("\r\n"), std::size_t{40})));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, '?');
  return "the file is neither SVG nor DXF: it begins with \"" + line + "\"";
}

// Names the line of a fault in the document as it was given, with its pictures, or else as it was parsed.
Error not_xml(const std::string& whole, const std::string& text, const pugi::xml_parse_result& parsed) {
  pugi::xml_document again;
  const pugi::xml_parse_result in_whole = parse(whole, again);
  const std::string& shown = in_whole ? text : whole;
  const auto offset =
      std::clamp<std::ptrdiff_t>((in_whole ? parsed : in_whole).offset, 0, static_cast<std::ptrdiff_t>(shown.size()));
  const auto line = std::count(shown.begin(), shown.begin() + offset, '\n') + 1;
  return malformed("line " + std::to_string(line) + ": not XML: " + parsed.description() + " at byte " +
                   std::to_string(offset));
}

// Returns the encoding that the XML declaration names, if it is unknown and the text was taken as ISO-8859-1. All of
// its characters beyond ASCII then have the first bytes of U+0080 to U+00FF.
std::string unknown_encoding(const std::string& text) {
  const auto is_beyond_ascii = [](char c) { return static_cast<unsigned char>(c) >= 0x80; };
  const auto is_beyond_latin1 = [](char c) { return static_cast<unsigned char>(c) > 0xc3; };
  if (text.substr(0, 5) != "<?xml" || std::none_of(text.begin(), text.end(), is_beyond_ascii) ||
      std::any_of(text.begin(), text.end(), is_beyond_latin1)) {
    return {};
  }
  const std::string_view declaration = std::string_view(text).substr(0, text.find("?>"));
  const std::size_t at = declaration.find("encoding");
  const std::size_t open = at == std::string_view::npos ? at : declaration.find_first_of("\"'", at);
  if (open == std::string_view::npos) return {};
  const std::size_t close = declaration.find(declaration[open], open + 1);
  std::string name = shortened(declaration.substr(open + 1, close - open - 1), 40);
  std::transform(name.begin(), name.end(), name.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  const bool is_known = name.substr(0, 3) == "utf" || name == "iso-8859-1" || name == "latin1" ||
                        name == "windows-1252" || name == "cp1252" || name == "us-ascii" || name == "ascii";
  return is_known ? std::string() : name;
}

}  // namespace

Result<std::string> outline_text(std::string_view data) {
  KERF_TRY_ASSIGN(const std::string bytes, unpacked(data));
  std::string text = without_embedded_data(text_of(bytes));
  if (text.size() <= kMaxTextBytes) return text;
  return invalid_argument("SVG_TOO_LARGE",
                          "the drawing has " + std::to_string(text.size()) +
                              " bytes without embedded pictures and fonts; the limit is 512 KiB",
                          kField);
}

Result<drawing::Drawing> read(std::string_view data, const ReadOptions& options) {
  KERF_TRY_ASSIGN(std::string outlines, outline_text(data));
  KERF_TRY_ASSIGN(const std::string text, with_entities(std::move(outlines), kMaxTextBytes));
  pugi::xml_document document;
  if (const pugi::xml_parse_result parsed = parse(text, document); !parsed) {
    if (const std::string kind = what_instead(text); !kind.empty()) return malformed(kind);
    KERF_TRY_ASSIGN(const std::string bytes, unpacked(data));
    return not_xml(text_of(bytes), text, parsed);
  }
  const pugi::xml_node root = document.document_element();
  if (!is_svg(root)) return malformed(std::string("the root element is '") + root.name() + "'; it must be svg");
  Walk walk(root, options);
  if (text.find("<?xml-stylesheet") != std::string::npos) walk.report("external style sheet");
  if (const std::string encoding = unknown_encoding(text); !encoding.empty()) {
    walk.report("encoding " + encoding + " (names are taken as ISO-8859-1)");
  }
  KERF_TRY(walk.run());
  return walk.take_drawing();
}

}  // namespace kerf::svg
