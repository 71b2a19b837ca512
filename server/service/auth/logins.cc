#include "server/service/auth/logins.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace kerf::auth {

void Logins::forget_old(std::int64_t now) {
  std::erase_if(logins_, [](const auto& one) { return !one.second.grant->check().ok(); });
  std::erase_if(links_, [now](const auto& one) {
    return now >= one.second.open_until_unix_s || !one.second.grant->check().ok();
  });
}

Result<std::string> Logins::add_login(const Caller& parent, std::int64_t until_unix_s) {
  forget_old(clock_());
  const auto of_token = [&parent](const auto& one) { return one.second.grant->token_id() == parent->token_id(); };
  if (std::count_if(logins_.begin(), logins_.end(), of_token) >= static_cast<std::ptrdiff_t>(kMaxLoginsOfToken)) {
    return resource_exhausted("TOO_MANY_LOGINS",
                              "this token has " + std::to_string(kMaxLoginsOfToken) +
                                  " logins, which is the limit; log out elsewhere or try again later");
  }
  if (logins_.size() >= kMaxLogins) {
    return resource_exhausted("TOO_MANY_LOGINS",
                              "there are " + std::to_string(kMaxLogins) +
                                  " logins, which is the limit; log out elsewhere or try again later");
  }
  std::string secret = new_secret();
  Rights rights = parent->rights();
  rights.until_unix_s = until_unix_s;
  logins_[digest_of(secret)] = {
      std::make_shared<Grant>(parent->token_id(), std::move(rights), clock_, Source::kLogin, parent.grant)};
  return secret;
}

Result<std::string> Logins::begin(const Caller& parent) {
  const std::lock_guard lock(mutex_);
  return add_login(parent, clock_() + kLoginSeconds);
}

Result<Caller> Logins::find(std::string_view secret) const {
  const std::lock_guard lock(mutex_);
  const auto found = logins_.find(digest_of(secret));
  if (found == logins_.end()) {
    return unauthenticated("LOGIN_UNKNOWN", "this login has ended; log in once more", "cookie");
  }
  KERF_TRY(found->second.grant->check());
  return Caller{found->second.grant, {}};
}

void Logins::end(std::string_view secret) {
  const std::lock_guard lock(mutex_);
  const auto found = logins_.find(digest_of(secret));
  if (found == logins_.end()) return;
  found->second.grant->withdraw();
  logins_.erase(found);
}

Result<std::string> Logins::make_link(const Caller& parent, const LinkTerms& terms) {
  const std::lock_guard lock(mutex_);
  const std::int64_t now = clock_();
  forget_old(now);
  const auto of_token = [&parent](const auto& one) { return one.second.grant->token_id() == parent->token_id(); };
  if (std::count_if(links_.begin(), links_.end(), of_token) >= static_cast<std::ptrdiff_t>(kMaxLinksOfToken)) {
    return resource_exhausted("TOO_MANY_LINKS", "this token has " + std::to_string(kMaxLinksOfToken) +
                                                    " links, which is the limit; try again once some have ended");
  }
  if (links_.size() >= kMaxLinks) {
    return resource_exhausted("TOO_MANY_LINKS", "there are " + std::to_string(kMaxLinks) +
                                                    " links, which is the limit; try again once some have ended");
  }
  std::string code = new_secret();
  links_[digest_of(code)] = {
      std::make_shared<Grant>(parent->token_id(), terms.rights, clock_, Source::kLink, parent.grant), terms.once,
      terms.once ? now + kLinkOnceSeconds : terms.rights.until_unix_s};
  return code;
}

Result<std::string> Logins::open_link(std::string_view code) {
  const std::lock_guard lock(mutex_);
  forget_old(clock_());
  const auto found = links_.find(digest_of(code));
  if (found == links_.end()) {
    return unauthenticated("CODE_UNKNOWN", "this link has ended or was opened before; ask for a new one", "code");
  }
  const Caller maker{found->second.grant, {}};
  KERF_TRY_ASSIGN(std::string secret, add_login(maker, maker->rights().until_unix_s));
  if (found->second.once) links_.erase(found);
  return secret;
}

}  // namespace kerf::auth
