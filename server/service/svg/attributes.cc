#include "server/service/svg/attributes.h"

#include <array>
#include <string>
#include <utility>

#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

// Lengths of the units in user units of 1/96 inch (CSS Values 3, section 5.2).
constexpr std::array<std::pair<std::string_view, double>, 12> kUnits{{
    {"", 1.0},
    {"px", 1.0},
    {"in", 96.0},
    {"cm", 96.0 / 2.54},
    {"mm", 96.0 / 25.4},
    {"q", 96.0 / 101.6},
    {"pt", 96.0 / 72.0},
    {"pc", 16.0},
    {"em", 16.0},
    {"ex", 8.0},
    {"rem", 16.0},
    {"ch", 8.0},
}};

}  // namespace

std::optional<double> parse_length(std::string_view text, double whole) {
  Scanner scanner(text);
  scanner.skip_blanks();
  const std::optional<double> number = scanner.number();
  if (!number) return std::nullopt;
  if (scanner.accept('%')) {
    scanner.skip_blanks();
    return scanner.at_end() ? std::optional<double>(0.01 * *number * whole) : std::nullopt;
  }
  std::string unit(scanner.word());  // in any case, as in style sheets
  for (char& c : unit) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
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
