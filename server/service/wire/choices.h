#pragma once

#include <algorithm>
#include <string>

#include "server/base/result.h"
#include "server/service/wire/geometry_codec.h"

// Converts enumerators of messages by arrays of pairs: (enumerator, meaning).
namespace kerf::wire {

// Decodes an enumerator; 0, which is no choice, leaves `choice` as it is. Errors: unknown_enum.
template <typename Pairs, typename Enumerator, typename Choice>
Status decode_choice(const Pairs& pairs, Enumerator given, const std::string& field, Choice& choice) {
  if (static_cast<int>(given) == 0) return Nothing{};
  for (const auto& [enumerator, meaning] : pairs) {
    if (enumerator != given) continue;
    choice = meaning;
    return Nothing{};
  }
  return unknown_enum(field, static_cast<int>(given));
}

// Encodes a choice, which must be among the pairs.
template <typename Pairs, typename Choice>
auto encode_choice(const Pairs& pairs, Choice choice) {
  return std::find_if(pairs.begin(), pairs.end(), [&](const auto& pair) { return pair.second == choice; })->first;
}

}  // namespace kerf::wire
