#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <pugixml.hpp>

#include "server/base/result.h"
#include "server/service/svg/css.h"
#include "server/service/svg/css_variables.h"

namespace kerf::svg {

// Comparisons of an element with a part of a selector, in a whole drawing. Matching ends with an error beyond that.
inline constexpr std::size_t kMaxCssSteps = 10'000'000;

// The values of an element's own properties; empty: none is set.
struct Declared {
  std::array<std::string, kNumProperties> values;
  CustomProperties custom;
  int unresolved = 0;  // Values that refer to a variable that is missing or invalid.

  [[nodiscard]] const std::string& operator[](Property property) const {
    return values[static_cast<std::size_t>(property)];
  }
};

// Finds what style sheets, style attributes and presentation attributes set for an element.
class Cascade {
 public:
  // `rules` must stay as it is.
  explicit Cascade(const StyleRules& rules);

  // Returns what is declared, with var() replaced. `variables`: those of the element around it, which become its own.
  // Error: kResourceExhausted SVG_TOO_COMPLEX, once all calls together exceed kMaxCssSteps.
  Result<Declared> declared(const pugi::xml_node& node, std::shared_ptr<const Variables>& variables);

 private:
  [[nodiscard]] bool matches(const Selector& selector, std::size_t last, const pugi::xml_node& node);
  [[nodiscard]] bool passes(const Compound& compound, const pugi::xml_node& node);
  [[nodiscard]] bool passes_attributes(const Compound& compound, const pugi::xml_node& node);
  [[nodiscard]] bool is_at(const PlaceTest& test, const pugi::xml_node& node);
  void collect(const std::vector<std::size_t>& candidates, const pugi::xml_node& node);

  const StyleRules& rules_;
  // Selectors by what their last part requires, each in one list.
  std::unordered_map<std::string, std::vector<std::size_t>> by_id_;
  std::unordered_map<std::string, std::vector<std::size_t>> by_class_;
  std::unordered_map<std::string, std::vector<std::size_t>> by_type_;
  std::vector<std::size_t> others_;
  std::vector<std::size_t> found_;  // Selectors that match the present element.
  std::size_t steps_ = 0;
};

// Returns the name of an element without the prefix of its namespace.
std::string_view local_name(const pugi::xml_node& node);

// Calls `use` with each word of a list separated by blanks.
template <typename Use>
void for_each_word(std::string_view list, const Use& use) {
  constexpr std::string_view kBlanks = " \t\n\r\f";
  while (true) {
    const std::size_t from = list.find_first_not_of(kBlanks);
    if (from == std::string_view::npos) return;
    list.remove_prefix(from);
    const std::size_t end = list.find_first_of(kBlanks);
    use(list.substr(0, end));
    if (end == std::string_view::npos) return;
    list.remove_prefix(end);
  }
}

}  // namespace kerf::svg
