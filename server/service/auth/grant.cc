#include "server/service/auth/grant.h"

#include <algorithm>

namespace kerf::auth {

Status Grant::check() const {
  if (is_withdrawn_) {
    return unauthenticated("TOKEN_UNKNOWN", "the token or login was withdrawn; log in with another one",
                           "authorization");
  }
  if (clock_ && rights_.is_over(clock_())) {
    return unauthenticated("TOKEN_EXPIRED", "the token or login has expired; log in with a newer one", "authorization");
  }
  return parent_ ? parent_->check() : Status(Nothing{});
}

std::int64_t Grant::ends_at() const {
  const std::int64_t own = rights_.until_unix_s;
  const std::int64_t before = parent_ ? parent_->ends_at() : 0;
  if (own == 0 || before == 0) return std::max(own, before);
  return std::min(own, before);
}

Caller everybody() {
  static const auto all = std::make_shared<const Grant>();
  return {all, {}};
}

}  // namespace kerf::auth
