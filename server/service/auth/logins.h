#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/service/auth/grant.h"
#include "server/service/auth/secrets.h"

namespace kerf::auth {

inline constexpr std::size_t kMaxLogins = 4096;
inline constexpr std::size_t kMaxLinks = 1024;
inline constexpr std::size_t kMaxLoginsOfToken = 512;  // Those by its links included.
inline constexpr std::size_t kMaxLinksOfToken = 128;
inline constexpr std::int64_t kLoginSeconds = 12 * 3600;
inline constexpr std::int64_t kLinkOnceSeconds = 60;  // Time within which a link is opened that can be opened once.

// Holds what a link grants to those who open it.
struct LinkTerms {
  Rights rights;  // `until_unix_s`: the end of the logins that it makes
  bool once = false;
};

// Keeps the logins of browsers and the links that make them, in memory. Secrets are kept as their SHA-256. Thread-safe.
class Logins {
 public:
  explicit Logins(UnixClock clock) : clock_(std::move(clock)) {}

  // Begins a login with the rights of `parent`, for at most 12 h, and returns its secret. Error kResourceExhausted
  // TOO_MANY_LOGINS, of the token or of all.
  Result<std::string> begin(const Caller& parent);
  // Returns what a login was granted. Errors: kUnauthenticated LOGIN_UNKNOWN, those of Grant::check().
  [[nodiscard]] Result<Caller> find(std::string_view secret) const;
  // Ends a login, if there is one: its streams end as well.
  void end(std::string_view secret);

  // Makes a link and returns its code. Error kResourceExhausted TOO_MANY_LINKS.
  Result<std::string> make_link(const Caller& parent, const LinkTerms& terms);
  // Begins a login by a code, for as long as the link says, and returns its secret. Errors: kUnauthenticated
  // CODE_UNKNOWN, also after its end or after it was opened once; those of begin().
  Result<std::string> open_link(std::string_view code);

 private:
  struct Login {
    std::shared_ptr<Grant> grant;
  };
  struct Link {
    std::shared_ptr<const Grant> grant;
    bool once = false;
    std::int64_t open_until_unix_s = 0;
  };

  // These need mutex_ held.
  void forget_old(std::int64_t now);
  Result<std::string> add_login(const Caller& parent, std::int64_t until_unix_s);

  const UnixClock clock_;
  mutable std::mutex mutex_;
  std::map<Digest, Login> logins_;
  std::map<Digest, Link> links_;
};

}  // namespace kerf::auth
