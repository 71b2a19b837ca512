#include "server/core/mesh/build/number_precision.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace kerf::mesh {
namespace {

// Share of the numbers that must use the last digit for it to be where they are rounded. Rounded numbers end in a zero
// once in ten times; coordinates along the axes of a file need no such digit.
constexpr double kRoundedShare = 0.4;
constexpr int kSureDigits = 5;  // fewer digits are often exact, as in 0.25

double power_of_ten(int exponent) {
  double power = 1.0;
  for (int i = 0; i < std::abs(exponent); ++i) power *= 10.0;
  return exponent < 0 ? 1.0 / power : power;
}

// Returns the exponent of the power of ten that is at most `value`, which is > 0.
int decimal_exponent(double value) {
  int exponent = 0;
  while (exponent < 300 && power_of_ten(exponent + 1) <= value) ++exponent;
  while (exponent > -300 && power_of_ten(exponent) > value) --exponent;
  return exponent;
}

}  // namespace

void NumberPrecision::add(std::string_view word, double value) {
  if (value == 0.0 || !std::isfinite(value)) return;
  int decimals = 0, digits = 0, zeros_at_end = 0;
  bool after_point = false;
  std::size_t at = 0;
  const std::size_t end = std::min(word.find_first_of("eEdD"), word.size());
  for (; at < end; ++at) {
    if (word[at] == '.') after_point = true;
    if (word[at] < '0' || word[at] > '9') continue;
    decimals += after_point ? 1 : 0;
    if (digits > 0 || word[at] != '0') ++digits;
    zeros_at_end = word[at] == '0' ? zeros_at_end + 1 : 0;
  }
  if (at < word.size()) {
    int exponent = 0;
    std::string_view text = word.substr(at + 1);
    if (text.starts_with('+')) text.remove_prefix(1);
    std::from_chars(text.data(), text.data() + text.size(), exponent);
    decimals -= std::clamp(exponent, -400, 400);
  }
  most_decimals_ = std::max(most_decimals_, std::min(decimals, kMost));
  most_digits_ = std::max(most_digits_, std::min(digits, kMost));
  ++with_decimals_[static_cast<std::size_t>(std::clamp(decimals - zeros_at_end, 0, kMost))];
  ++with_digits_[static_cast<std::size_t>(std::clamp(digits - zeros_at_end, 0, kMost))];
  ++num_;
  largest_ = std::max(largest_, std::abs(value));
}

void NumberPrecision::add_binary(double value, double relative) {
  if (!std::isfinite(value)) return;
  largest_ = std::max(largest_, std::abs(value));
  binary_ = std::max(binary_, relative);
}

double NumberPrecision::decimal_step() const {
  return power_of_ten(-most_decimals_);
}

double NumberPrecision::digit_step() const {
  return largest_ > 0.0 ? power_of_ten(decimal_exponent(largest_) - most_digits_ + 1) : 0.0;
}

double NumberPrecision::rounding() const {
  double step = binary_ * largest_;
  if (num_ == 0) return step;
  const auto share = [this](std::int64_t count) { return static_cast<double>(count) / static_cast<double>(num_); };
  if (share(with_decimals_[static_cast<std::size_t>(most_decimals_)]) >= kRoundedShare) {
    step = std::max(step, decimal_step());
  }
  if (most_digits_ < kSureDigits) return step;
  const auto most = static_cast<std::size_t>(most_digits_);
  if (share(with_digits_[most] + with_digits_[most - 1]) >= kRoundedShare) step = std::max(step, digit_step());
  return step;
}

double NumberPrecision::resolution() const {
  double step = rounding();
  if (num_ > 0 && most_decimals_ >= kSureDigits) step = std::max(step, decimal_step());
  return most_digits_ < kSureDigits && most_decimals_ < kSureDigits ? binary_ * largest_ : step;
}

}  // namespace kerf::mesh
