#include "server/service/svg/css.h"

#include <algorithm>
#include <utility>

#include "server/service/svg/css_scanner.h"
#include "server/service/svg/css_selector.h"
#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

constexpr std::size_t kMaxLayers = 1'000;
constexpr int kMaxBlockDepth = 16;                             // Nesting of rules, @media and its like.
constexpr std::size_t kMaxNestedBytes = std::size_t{8} << 20;  // Selectors of nested rules, written out.

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

// True if a condition of @media may hold on a screen, but depends on more than is known here.
bool has_unread_condition(std::string_view query) {
  const std::string text = lower(query);
  return text.find('(') != std::string::npos && text.find("prefers-color-scheme") == std::string::npos &&
         text.find("print") == std::string::npos;
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
        read_at_rule(scanner, {}, depth);
        continue;
      }
      const std::string_view selectors = scanner.until("{");
      if (!scanner.accept('{')) return;
      const std::string_view block = scanner.until("}");
      scanner.accept('}');
      read_block(std::string(trimmed(selectors)), block, depth);
    }
  }

 private:
  // `around`: the selectors of the rule that the at-rule stands in; empty if it stands in none.
  void read_at_rule(CssScanner& scanner, const std::string& around, int depth) {
    const std::string name = lower(scanner.identifier());
    const std::string_view prelude = scanner.until(";{");
    if (name == "import") ++rules_.imports;
    const std::uint32_t outer = layer_;
    if (name == "layer") enter_layers(prelude);
    if (scanner.accept(';') || !scanner.accept('{')) {
      layer_ = outer;
      return;
    }
    const std::string_view block = scanner.until("}");
    scanner.accept('}');
    if (name == "container" || name == "scope" || (name == "media" && has_unread_condition(prelude))) ++rules_.unread;
    const bool holds_rules = (name == "media" && applies_to_screen(prelude)) || name == "layer" ||
                             (name == "supports" && lower(trimmed(prelude)).compare(0, 3, "not") != 0);
    const bool is_read = holds_rules && depth < kMaxBlockDepth;
    if (is_read && around.empty()) read(block, depth + 1);
    if (is_read && !around.empty()) read_block(around, block, depth + 1);
    layer_ = outer;
  }

  // Numbers the layers of a list in the order of their first mention, and enters the last. Layers within layers count
  // as rules that are not understood.
  void enter_layers(std::string_view names) {
    if (layer_ != kNoLayer) ++rules_.unread;
    CssScanner scanner(names);
    do {
      const std::string name(trimmed(scanner.until(",")));
      if (name.find('.') != std::string::npos) ++rules_.unread;
      auto found = std::find(rules_.layers.begin(), rules_.layers.end(), name);
      if (found == rules_.layers.end() || name.empty()) found = rules_.layers.insert(rules_.layers.end(), name);
      layer_ = static_cast<std::uint32_t>(found - rules_.layers.begin());
      rules_.too_many = rules_.too_many || rules_.layers.size() > kMaxLayers;
    } while (scanner.accept(',') && !rules_.too_many);
  }

  // Reads the block of a rule: declarations, and rules that are nested in it.
  void read_block(const std::string& selectors, std::string_view block, int depth) {
    if (block.find_first_of("{@") == std::string_view::npos) return add(selectors, block);
    std::string declarations;  // Those since the last nested rule.
    CssScanner scanner(block);
    while (!rules_.too_many) {
      scanner.skip_blanks();
      if (scanner.at_end()) break;
      if (scanner.accept(';')) continue;
      if (scanner.accept('@')) {
        add(selectors, declarations);
        declarations.clear();
        read_at_rule(scanner, selectors, depth);
        continue;
      }
      const std::string_view item = scanner.until(";{");
      const bool is_rule = scanner.peek() == '{' && item.substr(0, 2) != "--";
      if (!is_rule) {
        declarations += item;
        declarations += scanner.until(";");  // A value with braces.
        declarations += ';';
        continue;
      }
      scanner.accept('{');
      const std::string_view inner = scanner.until("}");
      scanner.accept('}');
      add(selectors, declarations);
      declarations.clear();
      if (depth < kMaxBlockDepth) read_block(nested(selectors, item), inner, depth + 1);
    }
    add(selectors, declarations);
  }

  // Returns the selectors of a nested rule as if it stood by itself: & becomes each selector of the rule around it.
  std::string nested(const std::string& around, std::string_view selectors) {
    std::string result;
    CssScanner outer(around);
    do {
      const std::string_view parent = trimmed(outer.until(","));
      CssScanner inner(selectors);
      do {
        const std::string_view own = trimmed(inner.until(","));
        if (!result.empty()) result += ", ";
        result += with_parent(parent, own);
        num_bytes_ += parent.size() + own.size();
        rules_.too_many = rules_.too_many || num_bytes_ > kMaxNestedBytes;
      } while (inner.accept(',') && !rules_.too_many);
    } while (outer.accept(',') && !rules_.too_many);
    return result;
  }

  static std::string with_parent(std::string_view parent, std::string_view own) {
    const std::size_t first = own.find('&');
    if (first == std::string_view::npos) return std::string(parent) + " " + std::string(own);
    std::string result;
    std::string_view rest = own;
    for (std::size_t at = first; at != std::string_view::npos; at = rest.find('&')) {
      result += rest.substr(0, at);
      // Elsewhere than at the start a combinator within the parent would bind wrongly.
      const bool is_start = result.empty();
      result += is_start ? std::string(parent) : ":is(" + std::string(parent) + ")";
      rest.remove_prefix(at + 1);
    }
    return result.append(rest);
  }

  void add(const std::string& text, std::string_view block) {
    std::vector<Declaration> declarations = parse_declarations(block);
    if (declarations.empty()) return;
    std::optional<std::vector<Selector>> selectors = parse_selectors(text);
    if (!selectors) {
      ++rules_.unread;
      return;
    }
    for (Selector& selector : *selectors) {
      const auto is_unread = [](const Compound& each) { return each.unread; };
      if (std::any_of(selector.compounds.begin(), selector.compounds.end(), is_unread)) ++rules_.unread;
      selector.rule = rules_.rules.size();
      selector.layer = layer_;
      rules_.selectors.push_back(std::move(selector));
    }
    rules_.rules.push_back(std::move(declarations));
    rules_.too_many = rules_.too_many || rules_.selectors.size() > kMaxCssSelectors;
  }

  std::uint32_t layer_ = kNoLayer;
  std::size_t num_bytes_ = 0;  // Bytes of selectors of nested rules, as they were written out.
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
    const std::string given = scanner.identifier();
    const std::string custom = given.starts_with("--") ? given : std::string();
    const std::string name = lower(given);
    scanner.skip_blanks();
    const bool is_declaration = !name.empty() && scanner.accept(':');
    const std::string_view rest = scanner.until(";");
    const std::optional<Property> property = is_declaration ? property_named(name) : std::nullopt;
    if (!property && (custom.empty() || !is_declaration)) continue;
    auto [value, important] = value_of(rest);
    if (value.empty() || (value.size() > kMaxCssValue && property != Property::kD)) continue;
    // A later declaration replaces an earlier one of the same weight.
    const auto earlier =
        std::find_if(declarations.begin(), declarations.end(), [&, weight = important](const Declaration& each) {
          return each.important == weight && each.custom == custom && (!property || each.property == *property);
        });
    if (earlier != declarations.end()) declarations.erase(earlier);
    declarations.push_back({property.value_or(Property::kDisplay), std::move(value), important, custom});
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
