#include "client/load/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

namespace kerf::load {
namespace {

constexpr std::uint64_t kExact = std::uint64_t{1} << Histogram::kPreciseBits;  // Smaller values have bins of their own.
constexpr std::uint64_t kHalf = kExact / 2;

// Returns the bin of a value. Values of 2^k .. 2^(k+1) - 1 share kHalf bins by their leading kPreciseBits bits.
std::size_t class_of(std::uint64_t value) {
  if (value < kExact) return static_cast<std::size_t>(value);
  const int shift = static_cast<int>(std::bit_width(value)) - Histogram::kPreciseBits;
  return static_cast<std::size_t>(kHalf * static_cast<std::uint64_t>(shift) + (value >> static_cast<unsigned>(shift)));
}

std::uint64_t largest_of(std::size_t index) {
  const auto i = static_cast<std::uint64_t>(index);
  if (i < kExact) return i;
  const std::uint64_t shift = i / kHalf - 1;
  return ((i - kHalf * shift + 1) << shift) - 1;
}

}  // namespace

void Histogram::add(std::int64_t value, std::int64_t count) {
  if (count <= 0) return;
  value = std::max<std::int64_t>(value, 0);
  const std::size_t index = class_of(static_cast<std::uint64_t>(value));
  if (index >= counts_.size()) counts_.resize(index + 1);
  counts_[index] += count;
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = std::max(max_, value);
  sum_ += static_cast<double>(value) * static_cast<double>(count);
  count_ += count;
}

void Histogram::merge(const Histogram& other) {
  if (other.count_ == 0) return;
  counts_.resize(std::max(counts_.size(), other.counts_.size()));
  for (std::size_t i = 0; i < other.counts_.size(); ++i) counts_[i] += other.counts_[i];
  min_ = count_ == 0 ? other.min_ : std::min(min_, other.min_);
  max_ = std::max(max_, other.max_);
  sum_ += other.sum_;
  count_ += other.count_;
}

double Histogram::mean() const {
  return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_);
}

std::int64_t Histogram::quantile(double q) const {
  const auto wanted = static_cast<std::int64_t>(std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_)));
  std::int64_t below = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    below += counts_[i];
    if (below >= std::max<std::int64_t>(wanted, 1)) {
      return std::min(static_cast<std::int64_t>(largest_of(i)), max_);
    }
  }
  return 0;
}

std::int64_t Histogram::count_above(std::int64_t value) const {
  std::int64_t above = 0;
  for (std::size_t i = class_of(static_cast<std::uint64_t>(std::max<std::int64_t>(value, 0))) + 1; i < counts_.size();
       ++i) {
    above += counts_[i];
  }
  return above;
}

}  // namespace kerf::load
