#include "server/service/svg/css_match.h"

#include <algorithm>
#include <tuple>

namespace kerf::svg {
namespace {

bool has_class(const pugi::xml_node& node, std::string_view wanted) {
  bool found = false;
  for_each_word(node.attribute("class").value(), [&](std::string_view word) { found = found || word == wanted; });
  return found;
}

bool passes_test(const AttributeTest& test, const pugi::xml_node& node) {
  const pugi::xml_attribute attribute = node.attribute(test.name.c_str());
  if (!attribute) return false;
  const std::string_view value = attribute.value();
  const std::string_view wanted = test.value;
  bool found = false;
  switch (test.operation) {
    case '\0':
      return true;
    case '=':
      return value == wanted;
    case '~':
      for_each_word(value, [&](std::string_view word) { found = found || word == wanted; });
      return found;
    case '|':
      return value == wanted || value.substr(0, wanted.size() + 1) == std::string(wanted) + "-";
    case '^':
      return !wanted.empty() && value.substr(0, wanted.size()) == wanted;
    case '$':
      return !wanted.empty() && value.size() >= wanted.size() && value.substr(value.size() - wanted.size()) == wanted;
    default:
      return !wanted.empty() && value.find(wanted) != std::string_view::npos;
  }
}

pugi::xml_node element_beside(pugi::xml_node node, bool after) {
  do {
    node = after ? node.next_sibling() : node.previous_sibling();
  } while (node && node.type() != pugi::node_element);
  return node;
}

pugi::xml_node parent_element(const pugi::xml_node& node) {
  const pugi::xml_node parent = node.parent();
  return parent.type() == pugi::node_element ? parent : pugi::xml_node();
}

}  // namespace

std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

Cascade::Cascade(const StyleRules& rules) : rules_(rules) {
  for (std::size_t i = 0; i < rules.selectors.size(); ++i) {
    const Compound& last = rules.selectors[i].compounds.back();
    if (last.never) continue;
    if (!last.id.empty()) {
      by_id_[last.id].push_back(i);
    } else if (!last.classes.empty()) {
      by_class_[last.classes.front()].push_back(i);
    } else if (!last.type.empty()) {
      by_type_[last.type].push_back(i);
    } else {
      others_.push_back(i);
    }
  }
}

bool Cascade::is_at(const PlaceTest& test, const pugi::xml_node& node) {
  int place = 1;
  for (pugi::xml_node other = element_beside(node, test.from_end); other && steps_ <= kMaxCssSteps;
       other = element_beside(other, test.from_end)) {
    ++steps_;
    if (!test.of_type || local_name(other) == local_name(node)) ++place;
  }
  const int beyond = place - test.b;
  return test.a == 0 ? beyond == 0 : beyond % test.a == 0 && beyond / test.a >= 0;
}

bool Cascade::passes_attributes(const Compound& compound, const pugi::xml_node& node) {
  if (!compound.id.empty() && compound.id != node.attribute("id").value()) return false;
  if (!compound.classes.empty()) {
    steps_ += compound.classes.size() * (1 + std::string_view(node.attribute("class").value()).size() / 32);
  }
  return std::all_of(compound.classes.begin(), compound.classes.end(),
                     [&node](const std::string& each) { return has_class(node, each); }) &&
         std::all_of(compound.attributes.begin(), compound.attributes.end(), [&](const AttributeTest& test) {
           steps_ += 1 + std::string_view(node.attribute(test.name.c_str()).value()).size() / 32;
           return passes_test(test, node);
         });
}

bool Cascade::passes(const Compound& compound, const pugi::xml_node& node) {
  ++steps_;
  if (compound.never || steps_ > kMaxCssSteps) return false;
  if (!compound.type.empty() && compound.type != local_name(node)) return false;
  if (compound.is_root && parent_element(node)) return false;
  if (!passes_attributes(compound, node)) return false;
  const auto any = [&](const std::vector<Compound>& list) {
    return std::any_of(list.begin(), list.end(), [&](const Compound& each) { return passes(each, node); });
  };
  return std::all_of(compound.any_of.begin(), compound.any_of.end(), any) &&
         std::none_of(compound.none_of.begin(), compound.none_of.end(), any) &&
         std::all_of(compound.places.begin(), compound.places.end(),
                     [&](const PlaceTest& test) { return is_at(test, node); });
}

// Compares the parts up to `last` from right to left. Every element that a part may stand for is tried.
bool Cascade::matches(const Selector& selector, std::size_t last, const pugi::xml_node& node) {
  const Compound& compound = selector.compounds[last];
  if (!passes(compound, node)) return false;
  if (last == 0) return true;
  const bool up = compound.combinator == ' ' || compound.combinator == '>';
  const bool once = compound.combinator == '>' || compound.combinator == '+';
  for (pugi::xml_node other = up ? parent_element(node) : element_beside(node, false); other && steps_ <= kMaxCssSteps;
       other = up ? parent_element(other) : element_beside(other, false)) {
    ++steps_;
    if (matches(selector, last - 1, other)) return true;
    if (once) return false;
  }
  return false;
}

void Cascade::collect(const std::vector<std::size_t>& candidates, const pugi::xml_node& node) {
  for (const std::size_t at : candidates) {
    const Selector& selector = rules_.selectors[at];
    if (matches(selector, selector.compounds.size() - 1, node)) found_.push_back(at);
  }
}

Result<Declared> Cascade::declared(const pugi::xml_node& node, std::shared_ptr<const Variables>& variables) {
  Declared result;
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    const std::optional<Property> property = property_named(attribute.name());
    if (!property || *property >= Property::kTranslate) continue;
    if (*property != Property::kTransform && std::string_view(attribute.value()).size() > kMaxCssValue) continue;
    std::string_view value = attribute.value();
    const std::size_t from = value.find_first_not_of(" \t\n\r\f");
    if (from == std::string_view::npos) continue;
    value = value.substr(from, value.find_last_not_of(" \t\n\r\f") + 1 - from);
    result.values[static_cast<std::size_t>(*property)] = value;
  }
  found_.clear();
  const auto collect_from = [&](const auto& lists, const std::string& key) {
    const auto found = lists.find(key);
    if (found != lists.end()) collect(found->second, node);
  };
  if (!rules_.selectors.empty()) {
    collect_from(by_id_, node.attribute("id").value());
    for_each_word(node.attribute("class").value(),
                  [&](std::string_view word) { collect_from(by_class_, std::string(word)); });
    collect_from(by_type_, std::string(local_name(node)));
    collect(others_, node);
  }
  if (steps_ > kMaxCssSteps) {
    return resource_exhausted("SVG_TOO_COMPLEX",
                              "the style sheets of the drawing take too long to apply; simplify them", "cut.curve.svg");
  }
  // Later ones win, so the most specific come last. The indices of selectors follow the order of the text. Rules in no
  // layer win over those in layers; if they are important, it is the other way round.
  const auto sort_found = [&](bool important) {
    const auto rank = [&](std::size_t at) {
      const Selector& selector = rules_.selectors[at];
      return std::tuple(important ? kNoLayer - selector.layer : selector.layer, selector.specificity, at);
    };
    std::sort(found_.begin(), found_.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
  };
  const std::vector<Declaration> own = parse_declarations(node.attribute("style").value());
  for (const bool important : {false, true}) {
    const auto apply = [&](const std::vector<Declaration>& declarations) {
      for (const Declaration& each : declarations) {
        steps_ += 1 + each.value.size() / 32;
        if (each.important != important) continue;
        std::string& value =
            each.custom.empty() ? result.values[static_cast<std::size_t>(each.property)] : result.custom[each.custom];
        value = each.value;
      }
    };
    sort_found(important);
    for (const std::size_t at : found_) apply(rules_.rules[rules_.selectors[at].rule]);
    apply(own);
  }
  variables = variables_within(variables, result.custom, steps_);
  for (std::string& value : result.values)
    result.unresolved += replace_variables(value, variables.get(), steps_) ? 0 : 1;
  return result;
}

}  // namespace kerf::svg
