#pragma once

#include <algorithm>
#include <chrono>

namespace kerf {

// Limits a rate: `per_second` in the long run, and up to `burst` at once. Starts full.
class TokenBucket {
 public:
  using Time = std::chrono::nanoseconds;  // since any moment

  // `per_second` and `burst` are > 0. `now` is the starting time.
  TokenBucket(double per_second, double burst, Time now)
      : per_second_(per_second), burst_(burst), tokens_(burst), at_(now) {}

  // Takes tokens; returns false and takes none if there are not enough. `now` must not decrease.
  bool take(double tokens, Time now) {
    tokens_ = std::min(burst_, tokens_ + per_second_ * std::chrono::duration<double>(now - at_).count());
    at_ = now;
    if (tokens > tokens_) return false;
    tokens_ -= tokens;
    return true;
  }
  // Returns tokens that were taken but do not count.
  void give_back(double tokens) { tokens_ = std::min(burst_, tokens_ + tokens); }

 private:
  double per_second_;
  double burst_;
  double tokens_;
  Time at_;
};

}  // namespace kerf
