#include "server/service/svg/entities.h"

#include <map>
#include <utility>

#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

constexpr int kMaxEntityDepth = 8;

using Entities = std::map<std::string, std::string, std::less<>>;

// Reads the declarations of general entities with a value: <!ENTITY name "value">.
Entities entities_of(std::string_view subset) {
  constexpr std::string_view kDeclaration = "<!ENTITY";
  Entities entities;
  for (std::size_t at = subset.find(kDeclaration); at != std::string_view::npos; at = subset.find(kDeclaration, at)) {
    at += kDeclaration.size();
    std::string_view rest = trimmed(subset.substr(at));
    const std::size_t name_end = rest.find_first_of(" \t\r\n\"'>");
    if (name_end == std::string_view::npos) break;
    const std::string_view name = rest.substr(0, name_end);
    rest = trimmed(rest.substr(name_end));
    if (rest.empty() || (rest.front() != '"' && rest.front() != '\'')) continue;  // parameters and external ones
    const std::size_t end = rest.find(rest.front(), 1);
    if (end == std::string_view::npos) break;
    entities.emplace(name, rest.substr(1, end - 1));  // the first declaration counts
    at = static_cast<std::size_t>(rest.data() + end - subset.data());
  }
  return entities;
}

// Appends the text with its references replaced. Returns false as soon as bytes and references are too many together:
// references to nothing would add no bytes, however many there are.
bool append(std::string_view text, const Entities& entities, int depth, std::size_t max_bytes, std::size_t& references,
            std::string& result) {
  while (!text.empty()) {
    const std::size_t mark = text.find('&');
    result += text.substr(0, mark);
    if (result.size() + references > max_bytes) return false;
    if (mark == std::string_view::npos) return true;
    text.remove_prefix(mark);
    const std::size_t end = text.find_first_of("; \t\r\n<\"'", 1);
    const bool is_reference = end != std::string_view::npos && text[end] == ';';
    const auto found = is_reference ? entities.find(text.substr(1, end - 1)) : entities.end();
    if (found == entities.end() || depth == kMaxEntityDepth) {
      result += '&';
      text.remove_prefix(1);
      continue;
    }
    text.remove_prefix(end + 1);
    ++references;
    if (!append(found->second, entities, depth + 1, max_bytes, references, result)) return false;
  }
  return true;
}

}  // namespace

Result<std::string> with_entities(std::string text, std::size_t max_bytes) {
  const std::size_t type = text.find("<!DOCTYPE");
  if (type == std::string::npos) return text;
  const std::size_t open = text.find_first_of("[>", type);
  if (open == std::string::npos || text[open] == '>') return text;
  const std::size_t close = text.find("]", open);
  if (close == std::string::npos) return text;
  const Entities entities = entities_of(std::string_view(text).substr(open, close - open));
  if (entities.empty()) return text;
  std::string result = text.substr(0, close);
  std::size_t references = 0;
  if (append(std::string_view(text).substr(close), entities, 0, max_bytes, references, result)) return result;
  return invalid_argument(
      "SVG_TOO_LARGE",
      "the drawing has more than " + std::to_string(max_bytes) + " bytes and references with its entities replaced",
      "cut.curve.svg");
}

}  // namespace kerf::svg
