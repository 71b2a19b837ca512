#include "server/service/ws/header_list.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <system_error>

namespace kerf::ws {
namespace {

constexpr std::string_view kIdentity = "identity";
constexpr double kIdentityUnnamed = 1e-4;  // Below the least quality that a header can name, 0.001.

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

bool same_token(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

// Removes the text up to the first `separator`, and the separator; returns the text, trimmed.
std::string_view take_until(std::string_view& text, char separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view taken = trimmed(text.substr(0, end));
  text.remove_prefix(std::min(end + 1, text.size()));
  return taken;
}

// Parses "q=0.5"; returns 1 if it is missing, 0 if it is malformed.
double parse_weight(std::string_view weight) {
  if (weight.empty()) return 1.0;
  if (weight.size() < 3 || !same_token(weight.substr(0, 2), "q=")) return 0.0;
  double quality = 0.0;
  const char* const last = weight.data() + weight.size();
  const auto [end, error] = std::from_chars(weight.data() + 2, last, quality, std::chars_format::fixed);
  const bool valid = error == std::errc() && end == last && quality >= 0.0 && quality <= 1.0;
  return valid ? quality : 0.0;
}

std::optional<double> named_quality(std::string_view accept_encoding, std::string_view coding) {
  while (!accept_encoding.empty()) {
    std::string_view weight = take_until(accept_encoding, ',');
    if (same_token(take_until(weight, ';'), coding)) return parse_weight(trimmed(weight));
  }
  return std::nullopt;
}

}  // namespace

bool lists_token(std::string_view list, std::string_view token) {
  while (!list.empty()) {
    if (same_token(take_until(list, ','), token)) return true;
  }
  return false;
}

double coding_quality(std::string_view accept_encoding, std::string_view coding) {
  if (const std::optional<double> named = named_quality(accept_encoding, coding)) return *named;
  if (const std::optional<double> any = named_quality(accept_encoding, "*")) return *any;
  return coding == kIdentity ? kIdentityUnnamed : 0.0;
}

std::string_view best_coding(std::string_view accept_encoding, std::span<const std::string_view> codings) {
  std::string_view best = kIdentity;
  double most = 0.0;
  for (const std::string_view coding : codings) {
    const double quality = coding_quality(accept_encoding, coding);
    if (quality <= most) continue;
    best = coding;
    most = quality;
  }
  return coding_quality(accept_encoding, kIdentity) > most ? kIdentity : best;
}

}  // namespace kerf::ws
