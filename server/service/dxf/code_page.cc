#include "server/service/dxf/code_page.h"

#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "server/base/text_converter.h"
#include "server/base/text_encoding.h"

namespace kerf::dxf {
namespace {

constexpr std::size_t kHeaderBytes = std::size_t{64} << 10;  // The code page is among the first variables.

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return result;
}

// Returns the value of $DWGCODEPAGE; empty if there is none.
std::string code_page_of(std::string_view data) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::string_view header = data.substr(0, kHeaderBytes);
  const std::size_t at = header.find("$DWGCODEPAGE");
  if (at == std::string_view::npos) return {};
  const std::size_t code = header.find_first_of("\r\n", at);
  const std::size_t digit = header.find_first_not_of(kBlanks, code);
  if (digit == std::string_view::npos || header[digit] != '3') return {};
  const std::size_t from = header.find_first_not_of(kBlanks, digit + 1);
  if (from == std::string_view::npos) return {};
  return std::string(header.substr(from, header.find_first_of(kBlanks, from) - from));
}

// Returns the C library's name of a code page; empty if the page is none that drawings are in.
std::string encoding_of(const std::string& code_page) {
  const std::string name = upper(code_page);
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kNames{{{"GB2312", "CP936"},
                                                                                 {"BIG5", "CP950"},
                                                                                 {"KSC5601", "CP949"},
                                                                                 {"JOHAB", "CP1361"},
                                                                                 {"ANSI_1361", "CP1361"},
                                                                                 {"MAC-ROMAN", "MACINTOSH"}}};
  for (const auto& [theirs, ours] : kNames) {
    if (name == theirs) return std::string(ours);
  }
  if (name.starts_with("ISO8859-")) return "ISO-8859-" + name.substr(8, 2);
  const std::size_t digits = name.starts_with("ANSI_") ? 5 : name.starts_with("DOS") ? 3 : name.size();
  const std::string number = name.substr(digits);
  constexpr std::array<std::string_view, 30> kPages{
      "437", "850", "852", "855", "857", "860", "861", "862",  "863",  "864",  "865",  "866",  "869",  "874",  "932",
      "936", "949", "950", "720", "737", "775", "858", "1250", "1251", "1252", "1253", "1254", "1255", "1256", "1257"};
  for (const std::string_view page : kPages) {
    if (number == page) return "CP" + number;
  }
  return number == "1258" ? "CP1258" : "";
}

// Resolves \M+nXXXX, a character of two bytes in one of five code pages.
std::string without_escapes(const std::string& text) {
  constexpr std::string_view kMark = "\\M+";
  constexpr std::size_t kLength = 8;
  constexpr std::array<const char*, 5> kEncodings{"CP932", "CP950", "CP949", "CP1361", "CP936"};
  std::array<std::optional<TextConverter>, kEncodings.size()> converters;
  std::string result;
  std::size_t from = 0;
  for (std::size_t at = text.find(kMark); at != std::string::npos; at = text.find(kMark, at + 1)) {
    const char* const digits = text.data() + at + kMark.size() + 1;
    unsigned code = 0;
    if (at + kLength > text.size() || digits[-1] < '1' || digits[-1] > '5') continue;
    if (const auto [stop, fault] = std::from_chars(digits, digits + 4, code, 16); stop != digits + 4) continue;
    const auto which = static_cast<std::size_t>(digits[-1] - '1');
    if (!converters[which]) converters[which].emplace(kEncodings[which]);
    if (!converters[which]->is_known()) continue;
    result.append(text, from, at - from);
    const std::array<char, 2> bytes{static_cast<char>(code >> 8U), static_cast<char>(code & 0xffU)};
    const std::size_t first = bytes[0] == '\0' ? 1 : 0;
    converters[which]->append({bytes.data() + first, bytes.size() - first}, result);
    from = at + kLength;
  }
  if (from == 0) return text;
  return result.append(text, from);
}

}  // namespace

DecodedText decoded(std::string data) {
  DecodedText result;
  const bool is_utf16 = data.starts_with("\xff\xfe") || data.starts_with("\xfe\xff");
  if (is_utf16 || is_utf8(data)) {
    result.text = without_escapes(utf8_text(std::move(data)));
    return result;
  }
  const std::string code_page = code_page_of(data);
  const std::string encoding = encoding_of(code_page);
  if (!encoding.empty()) {
    if (TextConverter converter(encoding); converter.is_known()) {
      std::string text;
      converter.append(data, text);
      result.text = without_escapes(text);
      return result;
    }
  }
  result.unread = code_page.empty() ? "that the file does not name" : shortened(code_page, 40);
  result.text = without_escapes(utf8_text(std::move(data)));
  return result;
}

}  // namespace kerf::dxf
