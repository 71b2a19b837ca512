#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"
#include "server/service/auth/grant.h"
#include "server/service/auth/logins.h"
#include "server/service/auth/token_file.h"

namespace kerf::auth {

// Finds out who calls. Thread-safe.
class Authenticator {
 public:
  explicit Authenticator(UnixClock clock) : clock_(clock), logins_(std::move(clock)) {}

  // Takes these tokens in place of those before. A grant stays if its token is the same, else it is withdrawn, with
  // all that came from it.
  void set_tokens(std::vector<Token> tokens);

  // Returns what a token grants. Errors: kUnauthenticated TOKEN_UNKNOWN or TOKEN_EXPIRED.
  [[nodiscard]] Result<Caller> find(std::string_view token) const;
  // Returns what the value of an `authorization` header grants, "Bearer TOKEN". Errors: those of find();
  // kUnauthenticated TOKEN_MISSING if it is empty or of another kind.
  [[nodiscard]] Result<Caller> find_bearer(std::string_view authorization) const;

  [[nodiscard]] Logins& logins() { return logins_; }
  [[nodiscard]] std::int64_t now() const { return clock_(); }

 private:
  struct Known {
    Token token;
    std::shared_ptr<Grant> grant;
  };

  const UnixClock clock_;
  mutable std::mutex mutex_;
  std::map<std::string, Known, std::less<>> tokens_;  // by id
  Logins logins_;
};

}  // namespace kerf::auth
