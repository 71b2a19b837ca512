#include "server/service/svg/css_selector.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>
#include <utility>

#include "server/service/svg/css_scanner.h"
#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

constexpr int kMaxNesting = 4;                 // Depth of :not() and :is() in each other.
constexpr std::uint32_t kMostOfAKind = 1'000;  // Counted in a specificity.
constexpr std::uint32_t kOfIds = 1U << 20U;
constexpr std::uint32_t kOfClasses = 1U << 10U;

// Counts tests of a selector. The most specific of a list in :not() and :is() counts.
struct Specificity {
  std::uint32_t ids = 0;
  std::uint32_t classes = 0;
  std::uint32_t types = 0;

  [[nodiscard]] std::uint32_t value() const {
    return std::min(ids, kMostOfAKind) * kOfIds + std::min(classes, kMostOfAKind) * kOfClasses +
           std::min(types, kMostOfAKind);
  }
};

std::optional<PlaceTest> place_of(std::string_view argument) {
  std::string text;
  for (const char c : lower(argument)) {
    if (c != ' ' && c != '\t' && c != '\n' && c != '\r') text += c;
  }
  if (text == "odd") return PlaceTest{2, 1};
  if (text == "even") return PlaceTest{2, 0};
  const auto integer = [](std::string_view digits, int otherwise) -> std::optional<int> {
    if (digits.empty() || digits == "+") return otherwise;
    if (digits == "-") return -otherwise;
    if (digits.front() == '+') digits.remove_prefix(1);
    int value = 0;
    const auto [stop, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (fault != std::errc() || stop != digits.data() + digits.size()) return std::nullopt;
    return std::clamp(value, -1'000'000, 1'000'000);
  };
  const std::size_t n = text.find('n');
  if (n == std::string::npos) {
    const std::optional<int> b = text.empty() ? std::nullopt : integer(text, 0);
    return b ? std::optional(PlaceTest{0, *b}) : std::nullopt;
  }
  const std::optional<int> a = integer(std::string_view(text).substr(0, n), 1);
  const std::optional<int> b = integer(std::string_view(text).substr(n + 1), 0);
  return a && b ? std::optional(PlaceTest{*a, *b}) : std::nullopt;
}

class SelectorReader {
 public:
  SelectorReader(std::string_view text, int nesting) : scanner_(text), nesting_(nesting) {}

  std::optional<std::vector<Selector>> run() {
    std::vector<Selector> selectors;
    do {
      std::optional<Selector> selector = read_selector();
      if (!selector) return std::nullopt;
      selectors.push_back(std::move(*selector));
    } while (scanner_.accept(','));
    return scanner_.at_end() ? std::optional(std::move(selectors)) : std::nullopt;
  }

 private:
  std::optional<Selector> read_selector() {
    Selector selector;
    specificity_ = {};
    char combinator = '\0';
    scanner_.skip_blanks();
    while (true) {
      Compound compound;
      compound.combinator = combinator;
      if (!read_compound(compound)) return std::nullopt;
      selector.compounds.push_back(std::move(compound));
      const bool blank = scanner_.skip_blanks();
      const char next = scanner_.peek();
      if (scanner_.at_end() || next == ',') break;
      if (next == '>' || next == '+' || next == '~') {
        combinator = next;
        scanner_.step();
        scanner_.skip_blanks();
      } else if (blank) {
        combinator = ' ';
      } else {
        return std::nullopt;
      }
    }
    selector.specificity = specificity_.value();
    return selector;
  }

  bool read_compound(Compound& compound) {
    bool any = read_type(compound);
    while (true) {
      const char next = scanner_.peek();
      if (next == '.') {
        scanner_.step();
        compound.classes.push_back(scanner_.identifier());
        if (compound.classes.back().empty()) return false;
        ++specificity_.classes;
      } else if (next == '#') {
        if (!read_id(compound)) return false;
      } else if (next == '[') {
        if (!read_attribute(compound)) return false;
      } else if (next == ':') {
        if (!read_pseudo(compound)) return false;
      } else {
        return any;
      }
      any = true;
    }
  }

  // Reads the name of an element or *; a namespace before it is passed over.
  bool read_type(Compound& compound) {
    bool any = scanner_.accept('*');
    std::string name = any ? std::string() : scanner_.identifier();
    if (scanner_.accept('|')) {
      any = scanner_.accept('*');
      name = any ? std::string() : scanner_.identifier();
    }
    if (!name.empty()) ++specificity_.types;
    compound.type = std::move(name);
    return any || !compound.type.empty();
  }

  bool read_id(Compound& compound) {
    scanner_.step();
    const std::string id = scanner_.identifier();
    if (id.empty()) return false;
    if (!compound.id.empty() && compound.id != id) compound.never = true;
    compound.id = id;
    ++specificity_.ids;
    return true;
  }

  bool read_attribute(Compound& compound) {
    scanner_.step();
    scanner_.skip_blanks();
    AttributeTest test;
    test.name = scanner_.identifier();
    if (scanner_.peek() == '|') {
      scanner_.step();
      if (scanner_.peek() == '=') {
        test.operation = '|';
      } else {
        test.name += ":" + scanner_.identifier();  // A namespace; the document's prefix counts.
      }
    }
    scanner_.skip_blanks();
    if (test.operation == '\0' && std::string_view("~|^$*").find(scanner_.peek()) != std::string_view::npos &&
        scanner_.peek() != '\0') {
      test.operation = scanner_.peek();
      scanner_.step();
    }
    if (scanner_.accept('=')) {
      if (test.operation == '\0') test.operation = '=';
      scanner_.skip_blanks();
      const char quote = scanner_.peek();
      test.value = quote == '"' || quote == '\'' ? scanner_.quoted() : scanner_.identifier();
      if (test.value.empty()) test.value = trimmed(scanner_.until("] \t\n"));
    } else if (test.operation != '\0') {
      return false;
    }
    scanner_.until("]");  // A flag such as i.
    if (test.name.empty() || !scanner_.accept(']')) return false;
    compound.attributes.push_back(std::move(test));
    ++specificity_.classes;
    return true;
  }

  bool read_pseudo(Compound& compound) {
    scanner_.step();
    if (scanner_.accept(':')) compound.never = true;  // No pseudo-element has an outline.
    const std::string name = lower(scanner_.identifier());
    if (name.empty()) return false;
    std::string_view argument;
    if (scanner_.accept('(')) {
      argument = scanner_.until(")");
      if (!scanner_.accept(')')) return false;
    }
    if (name == "not" || name == "is" || name == "where" || name == "matches")
      return read_list(compound, name, argument);
    ++specificity_.classes;
    if (name == "root" || name == "scope") {
      compound.is_root = true;
    } else if (!read_place(compound, name, argument)) {
      constexpr std::array<std::string_view, 5> kUnread{"has", "lang", "dir", "empty", "nth-child"};
      compound.unread = !compound.never && std::find(kUnread.begin(), kUnread.end(), name) != kUnread.end();
      compound.never = true;
    }
    return true;
  }

  bool read_list(Compound& compound, const std::string& name, std::string_view argument) {
    if (nesting_ >= kMaxNesting) return false;
    const auto inner = SelectorReader(argument, nesting_ + 1).run();
    if (!inner) return false;
    std::vector<Compound> list;
    std::uint32_t most = 0;
    for (const Selector& selector : *inner) {
      list.push_back(selector.compounds.back());
      if (selector.compounds.size() > 1) {  // Combinators within a list are not followed.
        list.back().never = true;
        compound.unread = true;
      }
      most = std::max(most, selector.specificity);
    }
    if (name != "where") {
      specificity_.ids += most / kOfIds;
      specificity_.classes += most / kOfClasses % kOfClasses;
      specificity_.types += most % kOfClasses;
    }
    (name == "not" ? compound.none_of : compound.any_of).push_back(std::move(list));
    return true;
  }

  static bool read_place(Compound& compound, const std::string& name, std::string_view argument) {
    const bool of_type = name.size() > 8 && name.compare(name.size() - 8, 8, "-of-type") == 0;
    const std::string kind = of_type ? name.substr(0, name.size() - 8) : name.substr(0, name.find("-child"));
    if (!of_type && name.find("-child") == std::string::npos) return false;
    std::optional<PlaceTest> test = PlaceTest{0, 1};
    if (kind == "nth" || kind == "nth-last") {
      test = place_of(argument);
    } else if (kind != "first" && kind != "last" && kind != "only") {
      return false;
    }
    if (!test) return false;
    test->of_type = of_type;
    test->from_end = kind == "last" || kind == "nth-last";
    compound.places.push_back(*test);
    if (kind == "only") {
      test->from_end = true;
      compound.places.push_back(*test);
    }
    return true;
  }

  CssScanner scanner_;
  int nesting_;
  Specificity specificity_;
};

}  // namespace

std::optional<std::vector<Selector>> parse_selectors(std::string_view text) {
  return SelectorReader(text, 0).run();
}

}  // namespace kerf::svg
