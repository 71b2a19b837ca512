#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace kerf::mesh {

// Finds how exactly the numbers of a file are written, by their digits or by their binary type.
class NumberPrecision {
 public:
  // Counts a number as written in a text file. Zeros say nothing, nor do numbers that are not finite.
  void add(std::string_view word, double value);
  // Counts a number of a binary file with this relative precision, such as 2^-23.
  void add_binary(double value, double relative);

  // Returns the distance from one number of the file to the next where they are rounded, in units of the file; 0 if
  // most numbers have fewer digits than the others, so that they may well be exact.
  [[nodiscard]] double rounding() const;
  // Returns the distance at which two numbers may mean the same; 0 if the file has too few digits to be sure.
  [[nodiscard]] double resolution() const;

 private:
  static constexpr int kMost = 24;  // digits beyond this are counted as this many

  [[nodiscard]] double decimal_step() const;
  [[nodiscard]] double digit_step() const;

  std::array<std::int64_t, kMost + 1> with_decimals_{};  // numbers by decimals, without zeros at their end
  std::array<std::int64_t, kMost + 1> with_digits_{};    // numbers by significant digits, without zeros at their end
  std::int64_t num_ = 0;
  int most_decimals_ = 0;  // as written, with zeros at the end
  int most_digits_ = 0;    // see most_decimals_
  double largest_ = 0.0;
  double binary_ = 0.0;  // largest relative precision of binary numbers
};

}  // namespace kerf::mesh
