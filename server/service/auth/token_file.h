#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"
#include "server/service/auth/rights.h"
#include "server/service/auth/secrets.h"
#include "server/service/auth/tenant.h"

namespace kerf::auth {

inline constexpr std::size_t kMaxTokens = 10'000;
inline constexpr std::size_t kMaxTokenFileBytes = std::size_t{4} << 20U;

// A line of a token file. The file has no secret: a token is known by its SHA-256.
struct Token {
  std::string id;  // [a-z0-9][a-z0-9-]{0,31}
  Digest digest{};
  Rights rights;
};

struct TokenFile {
  std::vector<Tenant> tenants;
  std::vector<Token> tokens;
};

// Parses a token file. Lines are empty, comments after `#`, or
//   ID SHA-256 scope=view|cut|admin [tenant=NAME] [sheets=PATTERN] [until=YYYY-MM-DD]
//   tenant NAME [sheets=N] [vertices=N] [state-mib=N] [workers=X] [streams=N] [image-streams=N] [cuts-per-s=X]
// A token ends with the day before `until`, by UTC. One of a tenant reaches `NAME-*`, or sheets of a pattern that
// begins so. Error kInvalidArgument BAD_TOKEN_FILE, with the number of the line.
Result<TokenFile> parse_token_file(std::string_view text);

// A new token: its text, kerf_ID_SECRET, is for the user alone, and the line is for the token file.
struct NewToken {
  std::string text;
  std::string line;
};
struct TokenWish {
  std::string id;
  Scope scope = Scope::kView;
  std::string sheets;  // Pattern; empty: all, or all of the tenant.
  std::string until;   // YYYY-MM-DD; empty: it never ends.
  std::string tenant;  // Empty: none.
};
// Makes a token. Error kInvalidArgument BAD_TOKEN.
Result<NewToken> make_token(const TokenWish& wish);

// Returns the id in a token's text, or nothing if it is none.
std::string_view id_in(std::string_view token);

}  // namespace kerf::auth
