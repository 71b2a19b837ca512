#pragma once

#include <span>
#include <string_view>

// Headers whose value is a list, its entries separated by commas (RFC 9110, 5.6.1).
namespace kerf::ws {

// True if the list names `token`, without regard to case.
bool lists_token(std::string_view list, std::string_view token);

// The weight of `coding`, e.g. "br" or "identity", in an Accept-Encoding header, in 0..1 (RFC 9110, 12.5.3). 0 where it
// is refused or not named; "identity" not named weighs less than any coding that is.
double coding_quality(std::string_view accept_encoding, std::string_view coding);

// The one of `codings` that weighs most, the earlier one of two that weigh alike. "identity" where all weigh 0, or
// less than that.
std::string_view best_coding(std::string_view accept_encoding, std::span<const std::string_view> codings);

}  // namespace kerf::ws
