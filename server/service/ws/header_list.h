#pragma once

#include <span>
#include <string_view>

// Parses headers whose value is a list, with entries separated by commas (RFC 9110, 5.6.1).
namespace kerf::ws {

// True if the list names `token`, ignoring case.
bool lists_token(std::string_view list, std::string_view token);

// Returns the weight of `coding`, e.g. "br" or "identity", in an Accept-Encoding header, 0..1 (RFC 9110, 12.5.3). It is
// 0 if the coding is refused or not named; "identity" not named weighs less than any named coding.
double coding_quality(std::string_view accept_encoding, std::string_view coding);

// Returns the coding with the largest weight, the earlier one of equals. Returns "identity" if that weighs more, or if
// all weigh 0.
std::string_view best_coding(std::string_view accept_encoding, std::span<const std::string_view> codings);

}  // namespace kerf::ws
