#include "server/service/auth/rights.h"

#include <array>
#include <cstddef>
#include <utility>

namespace kerf::auth {
namespace {

constexpr std::array<std::pair<Scope, std::string_view>, 3> kScopes = {
    {{Scope::kView, "view"}, {Scope::kCut, "cut"}, {Scope::kAdmin, "admin"}}};

}  // namespace

std::string_view name_of(Scope scope) {
  for (const auto& [known, name] : kScopes) {
    if (known == scope) return name;
  }
  return {};
}

std::optional<Scope> scope_named(std::string_view name) {
  for (const auto& [scope, known] : kScopes) {
    if (known == name) return scope;
  }
  return std::nullopt;
}

bool matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0, t = 0;
  std::optional<std::size_t> star;  // Place of the last star, which may take more of the text.
  std::size_t taken = 0;            // End of what that star has taken.
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      taken = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p;
      ++t;
    } else if (star) {
      p = *star + 1;
      t = ++taken;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

}  // namespace kerf::auth
