#pragma once

#include <cstdint>
#include <vector>

namespace kerf::load {

// Counts of whole numbers >= 0 in classes that grow with the value (as HdrHistogram's do): up to 2^kPreciseBits exact,
// beyond that with kPreciseBits leading bits kept, so that a quantile is at most 1/128 above the value it stands for,
// and never below it. A few kilobytes whatever is added. A plain value.
class Histogram {
 public:
  static constexpr int kPreciseBits = 8;

  // Negative values count as 0.
  void add(std::int64_t value, std::int64_t count = 1);
  void merge(const Histogram& other);

  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] std::int64_t min() const { return count_ == 0 ? 0 : min_; }  // exact, as are max and mean
  [[nodiscard]] std::int64_t max() const { return max_; }
  [[nodiscard]] double mean() const;
  // The least value that at least the share `q` in 0..1 of all values does not exceed; 0 without values.
  [[nodiscard]] std::int64_t quantile(double q) const;
  // Of all values, how many exceed `value`, to the width of a class.
  [[nodiscard]] std::int64_t count_above(std::int64_t value) const;

 private:
  std::vector<std::int64_t> counts_;  // by class; as many as were needed
  std::int64_t count_ = 0;
  std::int64_t min_ = 0;
  std::int64_t max_ = 0;
  double sum_ = 0.0;
};

}  // namespace kerf::load
