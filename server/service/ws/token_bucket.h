#pragma once

#include <algorithm>
#include <chrono>

namespace kerf::ws {

// Bounds how much may come: `per_second` in the long run, and up to `burst` at once. Starts full.
class TokenBucket {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Both > 0. `now` is the time at which it begins.
  TokenBucket(double per_second, double burst, Time now)
      : per_second_(per_second), burst_(burst), tokens_(burst), at_(now) {}

  // False, and nothing is taken, where there is not so much. `now` never goes back.
  bool take(double tokens, Time now) {
    tokens_ = std::min(burst_, tokens_ + per_second_ * std::chrono::duration<double>(now - at_).count());
    at_ = now;
    if (tokens > tokens_) return false;
    tokens_ -= tokens;
    return true;
  }
  // Gives back what was taken and does not count after all.
  void give_back(double tokens) { tokens_ = std::min(burst_, tokens_ + tokens); }

 private:
  double per_second_;
  double burst_;
  double tokens_;
  Time at_;
};

}  // namespace kerf::ws
