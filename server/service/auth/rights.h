#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kerf::auth {

// Kinds of rights in order: each includes those before it.
enum class Scope : std::uint8_t {
  kView = 1,  // to watch, list and export
  kCut,       // to change sheets that are there
  kAdmin,     // to make and delete sheets; with all sheets, also to look after the store
};

std::string_view name_of(Scope scope);
std::optional<Scope> scope_named(std::string_view name);

// Returns true if a pattern fits the whole text: `*` stands for any characters, `?` for one.
bool matches(std::string_view pattern, std::string_view text);

// Says what a caller may do.
struct Rights {
  Scope scope = Scope::kAdmin;
  std::string sheets = "*";       // Pattern of the ids of sheets that it reaches, see matches().
  std::int64_t until_unix_s = 0;  // s since 1970, when it ends; 0: never
  std::string tenant = {};        // Name of the tenant whose limits count; empty: none.

  [[nodiscard]] bool reaches_all() const { return sheets == "*"; }
  [[nodiscard]] bool reaches(std::string_view sheet_id) const { return matches(sheets, sheet_id); }
  [[nodiscard]] bool is_over(std::int64_t now_unix_s) const { return until_unix_s != 0 && now_unix_s >= until_unix_s; }
};

}  // namespace kerf::auth
