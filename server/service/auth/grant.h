#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "server/base/result.h"
#include "server/service/auth/rights.h"

namespace kerf::auth {

// Returns s since 1970.
using UnixClock = std::function<std::int64_t()>;

// Says where a grant comes from.
enum class Source : std::uint8_t {
  kToken,
  kLogin,  // a login by a token
  kLink,   // a link that the owner of a token made, or a login by it
};

// Holds what a caller was granted, by a token, or by a login or link that a token made. It ends with the grant that it
// comes from. Thread-safe.
class Grant {
 public:
  // Grants the rights of a token. `parent`: the grant that it comes from, or none.
  Grant(std::string token_id, Rights rights, UnixClock clock, Source source = Source::kToken,
        std::shared_ptr<const Grant> parent = nullptr)
      : token_id_(std::move(token_id)),
        rights_(std::move(rights)),
        clock_(std::move(clock)),
        source_(source),
        parent_(std::move(parent)) {}
  // Grants everything to everybody.
  Grant() = default;
  Grant(const Grant&) = delete;
  Grant& operator=(const Grant&) = delete;

  [[nodiscard]] const std::string& token_id() const { return token_id_; }  // Empty: of everybody.
  [[nodiscard]] const Rights& rights() const { return rights_; }
  // True if its holder came by a link, and need not be the owner of the token.
  [[nodiscard]] bool is_by_link() const { return source_ == Source::kLink || (parent_ && parent_->is_by_link()); }
  // Errors: kUnauthenticated TOKEN_EXPIRED, or TOKEN_UNKNOWN after it was withdrawn.
  [[nodiscard]] Status check() const;
  // Makes check() fail from now on.
  void withdraw() { is_withdrawn_ = true; }
  // Returns the time at which it ends by itself, s since 1970; 0: never.
  [[nodiscard]] std::int64_t ends_at() const;

 private:
  std::string token_id_;
  Rights rights_;
  UnixClock clock_;  // Empty: it never ends by itself.
  Source source_ = Source::kToken;
  std::shared_ptr<const Grant> parent_;
  std::atomic<bool> is_withdrawn_ = false;
};

// Who calls, and from where.
struct Caller {
  std::shared_ptr<const Grant> grant;  // never null
  std::string address;                 // IPv4 or IPv6, without a port; empty: unknown.

  const Grant* operator->() const { return grant.get(); }
};

// Returns the caller of a server that asks for no tokens, who may do everything.
Caller everybody();

}  // namespace kerf::auth
