#include "server/service/svg/attributes.h"

#include <array>
#include <utility>

#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

// Lengths of the units in user units of 1/96 inch (CSS Values 3, section 5.2).
constexpr std::array<std::pair<std::string_view, double>, 10> kUnits{{
    {"", 1.0},
    {"px", 1.0},
    {"in", 96.0},
    {"cm", 96.0 / 2.54},
    {"mm", 96.0 / 25.4},
    {"Q", 96.0 / 101.6},
    {"pt", 96.0 / 72.0},
    {"pc", 16.0},
    {"em", 16.0},
    {"ex", 8.0},
}};

}  // namespace

std::string property(const pugi::xml_node& node, std::string_view name) {
  std::string_view style = node.attribute("style").value();
  std::string_view found;  // The last declaration counts.
  while (!style.empty()) {
    const std::size_t end = style.find(';');
    const std::string_view declaration = style.substr(0, end);
    const std::size_t colon = declaration.find(':');
    if (colon != std::string_view::npos && trimmed(declaration.substr(0, colon)) == name) {
      found = trimmed(declaration.substr(colon + 1));
      found = trimmed(found.substr(0, found.find('!')));  // Cuts off "!important".
    }
    style = end == std::string_view::npos ? std::string_view() : style.substr(end + 1);
  }
  if (!found.empty()) return std::string(found);
  return std::string(trimmed(node.attribute(std::string(name).c_str()).value()));
}

std::optional<double> parse_length(std::string_view text, double whole) {
  Scanner scanner(text);
  scanner.skip_blanks();
  const std::optional<double> number = scanner.number();
  if (!number) return std::nullopt;
  if (scanner.accept('%')) {
    scanner.skip_blanks();
    return scanner.at_end() ? std::optional<double>(0.01 * *number * whole) : std::nullopt;
  }
  const std::string_view unit = scanner.word();
  scanner.skip_blanks();
  if (!scanner.at_end()) return std::nullopt;
  for (const auto& [name, size] : kUnits) {
    if (name == unit) return *number * size;
  }
  return std::nullopt;
}

double length_of(const pugi::xml_node& node, const char* name, double whole, double otherwise) {
  const pugi::xml_attribute attribute = node.attribute(name);
  return attribute ? parse_length(attribute.value(), whole).value_or(otherwise) : otherwise;
}

}  // namespace kerf::svg
