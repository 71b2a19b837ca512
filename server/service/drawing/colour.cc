#include "server/service/drawing/colour.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <vector>

#include "server/service/drawing/colour_names.h"

namespace kerf::drawing {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower;
  for (const char c : text) {
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f') {
      if (!lower.empty() && lower.back() != ' ') lower += ' ';
    } else {
      lower += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
  }
  if (!lower.empty() && lower.back() == ' ') lower.pop_back();
  return lower;
}

std::optional<Colour> from_hex(std::string_view digits) {
  std::string wide;
  for (const char c : digits) wide.append(digits.size() <= 4 ? 2 : 1, c);
  if (wide.size() != 6 && wide.size() != 8) return std::nullopt;
  std::uint32_t value = 0;
  const auto [stop, fault] = std::from_chars(wide.data(), wide.data() + wide.size(), value, 16);
  if (fault != std::errc() || stop != wide.data() + wide.size()) return std::nullopt;
  if (wide.size() == 6) return Colour{value, 1.0};
  return Colour{value >> 8U, (value & 0xffU) / 255.0};
}

struct Argument {
  double value = 0.0;
  std::string_view unit;
};

// Splits "(1, 50% 3 / .5)" into numbers and units. Returns an empty list if it is malformed.
std::vector<Argument> arguments_of(std::string_view text) {
  std::vector<Argument> found;
  if (text.size() < 2 || text.front() != '(' || text.back() != ')') return {};
  const char* at = text.data() + 1;
  const char* const end = text.data() + text.size() - 1;
  const auto separates = [](char c) { return c == ' ' || c == ',' || c == '/'; };
  while (true) {
    while (at != end && separates(*at)) ++at;
    if (at == end) return found;
    if (*at == '+') ++at;
    Argument argument;
    const auto [stop, fault] = std::from_chars(at, end, argument.value);
    if (fault != std::errc()) return {};
    at = stop;
    while (at != end && !separates(*at)) ++at;
    argument.unit = std::string_view(stop, static_cast<std::size_t>(at - stop));
    found.push_back(argument);
  }
}

std::uint32_t channel(double share) {
  return static_cast<std::uint32_t>(std::clamp(share, 0.0, 1.0) * 255.0 + 0.5);
}

std::uint32_t packed(double red, double green, double blue) {
  return channel(red) << 16U | channel(green) << 8U | channel(blue);
}

double alpha_of(const Argument& argument) {
  return std::clamp(argument.unit == "%" ? argument.value / 100.0 : argument.value, 0.0, 1.0);
}

std::optional<Colour> from_rgb(const std::vector<Argument>& a) {
  const auto share = [](const Argument& each) { return each.value / (each.unit == "%" ? 100.0 : 255.0); };
  return Colour{packed(share(a[0]), share(a[1]), share(a[2])), a.size() == 4 ? alpha_of(a[3]) : 1.0};
}

// CSS Color 4, section 7.1.
std::optional<Colour> from_hsl(const std::vector<Argument>& a) {
  double turns = a[0].value / 360.0;
  if (a[0].unit == "turn") turns = a[0].value;
  if (a[0].unit == "grad") turns = a[0].value / 400.0;
  if (a[0].unit == "rad") turns = a[0].value / 6.283185307179586;
  if (!(turns > -1e6 && turns < 1e6)) return std::nullopt;
  turns -= static_cast<double>(static_cast<long long>(turns));
  if (turns < 0.0) turns += 1.0;
  const double saturation = std::clamp(a[1].value / 100.0, 0.0, 1.0);
  const double lightness = std::clamp(a[2].value / 100.0, 0.0, 1.0);
  const auto share = [&](double n) {
    double k = n + 12.0 * turns;
    while (k >= 12.0) k -= 12.0;
    const double reach = saturation * std::min(lightness, 1.0 - lightness);
    return lightness - reach * std::max(-1.0, std::min({k - 3.0, 9.0 - k, 1.0}));
  };
  return Colour{packed(share(0.0), share(8.0), share(4.0)), a.size() == 4 ? alpha_of(a[3]) : 1.0};
}

}  // namespace

std::optional<Colour> parse_colour(std::string_view text) {
  const std::string given = lower_case(text);
  const std::string_view value = given;
  if (value.empty()) return std::nullopt;
  if (value.front() == '#') return from_hex(value.substr(1));
  if (value == "transparent") return Colour{0, 0.0};
  const std::size_t bracket = value.find('(');
  if (bracket != std::string_view::npos) {
    std::string_view name = value.substr(0, bracket);
    if (!name.empty() && name.back() == 'a') name.remove_suffix(1);
    const std::vector<Argument> arguments = arguments_of(value.substr(bracket));
    if (arguments.size() != 3 && arguments.size() != 4) return std::nullopt;
    if (name == "rgb") return from_rgb(arguments);
    return name == "hsl" ? from_hsl(arguments) : std::nullopt;
  }
  const auto found =
      std::find_if(kColourNames.begin(), kColourNames.end(), [value](const auto& each) { return each.first == value; });
  return found == kColourNames.end() ? std::nullopt : std::optional<Colour>({found->second, 1.0});
}

std::string name_of_colour(std::uint32_t rgb) {
  const auto found =
      std::find_if(kColourNames.begin(), kColourNames.end(), [rgb](const auto& each) { return each.second == rgb; });
  if (found != kColourNames.end()) return std::string(found->first);
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%06x", rgb & 0xffffffU);
  return text.data();
}

}  // namespace kerf::drawing
