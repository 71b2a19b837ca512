#include "server/service/svg/css.h"

#include <algorithm>
#include <utility>

#include "server/service/svg/css_scanner.h"
#include "server/service/svg/css_selector.h"
#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

constexpr int kMaxBlockDepth = 16;  // Nesting of @media and its like.

// Returns the value without comments, and whether it ends with "!important".
std::pair<std::string, bool> value_of(std::string_view text) {
  std::string value;
  while (!text.empty()) {
    const std::size_t comment = text.find("/*");
    value += text.substr(0, comment);
    if (comment == std::string_view::npos) break;
    const std::size_t end = text.find("*/", comment + 2);
    value += ' ';
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 2);
  }
  bool important = false;
  const std::size_t mark = value.rfind('!');
  if (mark != std::string::npos) {
    important = lower(trimmed(std::string_view(value).substr(mark + 1))) == "important";
    value.resize(mark);
  }
  return {std::string(trimmed(value)), important};
}

bool query_applies(std::string_view query) {
  CssScanner scanner(query);
  scanner.skip_blanks();
  std::string word = lower(scanner.identifier());
  bool negated = false;
  if (word == "not" || word == "only") {
    negated = word == "not";
    scanner.skip_blanks();
    word = lower(scanner.identifier());
  }
  bool applies = word.empty() || word == "all" || word == "screen";
  while (!scanner.at_end()) {
    scanner.skip_blanks();
    if (scanner.accept('(')) {
      std::string feature;
      for (const char c : lower(scanner.until(")"))) {
        if (c != ' ') feature += c;
      }
      scanner.accept(')');
      applies = applies && feature == "prefers-color-scheme:light";
    } else if (scanner.identifier().empty() && !scanner.at_end()) {
      scanner.step();
    }
  }
  return applies != negated;
}

class SheetReader {
 public:
  explicit SheetReader(StyleRules& rules) : rules_(rules) {}

  void read(std::string_view text, int depth) {
    CssScanner scanner(text);
    while (!rules_.too_many) {
      scanner.skip_blanks();
      if (scanner.at_end()) return;
      if (scanner.accept('@')) {
        read_at_rule(scanner, depth);
        continue;
      }
      const std::string_view selectors = scanner.until("{");
      if (!scanner.accept('{')) return;
      const std::string_view block = scanner.until("}");
      scanner.accept('}');
      add(selectors, block);
    }
  }

 private:
  void read_at_rule(CssScanner& scanner, int depth) {
    const std::string name = lower(scanner.identifier());
    const std::string_view prelude = scanner.until(";{");
    if (name == "import") ++rules_.imports;
    if (scanner.accept(';') || !scanner.accept('{')) return;
    const std::string_view block = scanner.until("}");
    scanner.accept('}');
    const bool holds_rules = (name == "media" && applies_to_screen(prelude)) || name == "layer" ||
                             (name == "supports" && lower(trimmed(prelude)).compare(0, 3, "not") != 0);
    if (holds_rules && depth < kMaxBlockDepth) read(block, depth + 1);
  }

  void add(std::string_view text, std::string_view block) {
    std::vector<Declaration> declarations = parse_declarations(block);
    if (declarations.empty()) return;
    std::optional<std::vector<Selector>> selectors = parse_selectors(text);
    if (!selectors) return;
    for (Selector& selector : *selectors) {
      selector.rule = rules_.rules.size();
      rules_.selectors.push_back(std::move(selector));
    }
    rules_.rules.push_back(std::move(declarations));
    rules_.too_many = rules_.selectors.size() > kMaxCssSelectors;
  }

  StyleRules& rules_;
};

}  // namespace

std::optional<Property> property_named(std::string_view name) {
  const auto found = std::find(kPropertyNames.begin(), kPropertyNames.end(), name);
  if (found == kPropertyNames.end()) return std::nullopt;
  return static_cast<Property>(found - kPropertyNames.begin());
}

std::vector<Declaration> parse_declarations(std::string_view text) {
  std::vector<Declaration> declarations;
  CssScanner scanner(text);
  while (true) {
    scanner.skip_blanks();
    if (scanner.at_end()) return declarations;
    if (scanner.accept(';')) continue;
    const std::string name = lower(scanner.identifier());
    scanner.skip_blanks();
    const bool is_declaration = !name.empty() && scanner.accept(':');
    const std::string_view rest = scanner.until(";");
    const std::optional<Property> property = is_declaration ? property_named(name) : std::nullopt;
    if (!property) continue;
    auto [value, important] = value_of(rest);
    if (value.empty() || value.size() > kMaxCssValue) continue;
    // A later declaration replaces an earlier one of the same weight.
    const auto earlier = std::find_if(
        declarations.begin(), declarations.end(),
        [&, weight = important](const auto& each) { return each.property == *property && each.important == weight; });
    if (earlier != declarations.end()) declarations.erase(earlier);
    declarations.push_back({*property, std::move(value), important});
  }
}

void parse_style_sheet(std::string_view text, StyleRules& rules) {
  SheetReader(rules).read(text, 0);
}

bool applies_to_screen(std::string_view media) {
  if (trimmed(media).empty()) return true;
  CssScanner scanner(media);
  do {
    if (query_applies(scanner.until(","))) return true;
  } while (scanner.accept(','));
  return false;
}

}  // namespace kerf::svg
