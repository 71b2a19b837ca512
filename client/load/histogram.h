#pragma once

#include <cstdint>
#include <vector>

namespace kerf::load {

// Counts whole numbers >= 0 in bins that grow with the value, as in HdrHistogram. Values up to 2^kPreciseBits are
// exact; larger ones keep kPreciseBits leading bits. A quantile is thus at most 1/128 above the true value and never
// below it. A histogram takes a few kilobytes regardless of the number of values, and can be copied.
class Histogram {
 public:
  static constexpr int kPreciseBits = 8;

  // Adds a value; negative values count as 0.
  void add(std::int64_t value, std::int64_t count = 1);
  void merge(const Histogram& other);

  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] std::int64_t min() const { return count_ == 0 ? 0 : min_; }  // Exact, as are max and mean.
  [[nodiscard]] std::int64_t max() const { return max_; }
  [[nodiscard]] double mean() const;
  // Returns the smallest value not exceeded by at least the share `q` in 0..1 of all values; 0 without values.
  [[nodiscard]] std::int64_t quantile(double q) const;
  // Returns how many values exceed `value`, as exactly as the bins allow.
  [[nodiscard]] std::int64_t count_above(std::int64_t value) const;

 private:
  std::vector<std::int64_t> counts_;  // Number of values in each bin, up to the last bin in use.
  std::int64_t count_ = 0;
  std::int64_t min_ = 0;
  std::int64_t max_ = 0;
  double sum_ = 0.0;
};

}  // namespace kerf::load
