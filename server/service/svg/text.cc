#include "server/service/svg/text.h"

#include "server/base/text_encoding.h"

namespace kerf::svg {
namespace {

bool begins_at(std::string_view text, std::size_t at, std::string_view with) {
  return text.substr(at, with.size()) == with;
}

}  // namespace

std::string text_of(std::string_view data) {
  // Without its mark, UTF-16 is known by the bracket with which XML begins.
  if (begins_at(data, 0, std::string_view("<\0", 2))) return utf8_text("\xff\xfe" + std::string(data));
  if (begins_at(data, 0, std::string_view("\0<", 2))) return utf8_text("\xfe\xff" + std::string(data));
  return utf8_text(std::string(data));
}

std::string without_embedded_data(std::string_view text) {
  constexpr std::string_view kData = "data:";
  std::string result;
  std::size_t copied = 0;
  for (std::size_t at = text.find(kData); at != std::string_view::npos; at = text.find(kData, at)) {
    std::size_t before = at;
    while (before > 0 && (text[before - 1] == ' ' || text[before - 1] == '\n')) --before;
    const char opening = before == 0 ? '\0' : text[before - 1];
    at += kData.size();
    if (opening != '"' && opening != '\'' && opening != '(') continue;
    const std::size_t end = text.find(opening == '(' ? ')' : opening, at);
    if (end == std::string_view::npos) break;
    result += text.substr(copied, at - copied);
    copied = at = end;
  }
  result += text.substr(copied);
  return result;
}

}  // namespace kerf::svg
