#include "server/service/auth/authenticator.h"

#include <utility>

namespace kerf::auth {
namespace {

bool are_same(const Token& a, const Token& b) {
  return a.digest == b.digest && a.rights.scope == b.rights.scope && a.rights.sheets == b.rights.sheets &&
         a.rights.until_unix_s == b.rights.until_unix_s && a.rights.tenant == b.rights.tenant;
}

bool is_bearer(std::string_view scheme) {
  constexpr std::string_view kBearer = "bearer ";
  if (scheme.size() != kBearer.size()) return false;
  for (std::size_t i = 0; i < scheme.size(); ++i) {
    if ((static_cast<unsigned char>(scheme[i]) | 0x20U) != static_cast<unsigned char>(kBearer[i])) return false;
  }
  return true;
}

}  // namespace

void Authenticator::set_tokens(std::vector<Token> tokens) {
  const std::lock_guard lock(mutex_);
  std::map<std::string, Known, std::less<>> before = std::exchange(tokens_, {});
  for (Token& token : tokens) {
    const auto known = before.find(token.id);
    if (known != before.end() && are_same(known->second.token, token)) {
      tokens_.insert(before.extract(known));
      continue;
    }
    auto grant = std::make_shared<Grant>(token.id, token.rights, clock_);
    std::string id = token.id;
    tokens_.emplace(std::move(id), Known{std::move(token), std::move(grant)});
  }
  for (const auto& [id, gone] : before) gone.grant->withdraw();
}

Result<Caller> Authenticator::find(std::string_view token) const {
  const Digest digest = digest_of(token);
  const std::lock_guard lock(mutex_);
  const auto known = tokens_.find(id_in(token));
  if (known == tokens_.end() || !are_equal(known->second.token.digest, digest)) {
    return unauthenticated("TOKEN_UNKNOWN", "this server does not know the token; ask its operator for one",
                           "authorization");
  }
  KERF_TRY(known->second.grant->check());
  return Caller{known->second.grant, {}};
}

Result<Caller> Authenticator::find_bearer(std::string_view authorization) const {
  constexpr std::size_t kScheme = 7;
  if (!is_bearer(authorization.substr(0, kScheme))) {
    return unauthenticated("TOKEN_MISSING", "this server asks for a token: send it as `authorization: Bearer TOKEN`",
                           "authorization");
  }
  return find(authorization.substr(kScheme));
}

}  // namespace kerf::auth
