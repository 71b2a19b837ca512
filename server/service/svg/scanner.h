#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace kerf::svg {

// Tokenizes the small languages inside attributes, from left to right.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  [[nodiscard]] bool at_end() const { return at_ == text_.size(); }
  [[nodiscard]] std::size_t position() const { return at_; }
  [[nodiscard]] char peek() const { return at_end() ? '\0' : text_[at_]; }
  // True if a number can start here.
  [[nodiscard]] bool at_number() const;

  void skip_blanks();
  // Skips blanks with at most one comma among them; returns true if it found a comma.
  bool skip_separator();
  // Consumes the next character if it is `wanted`; returns true if it was.
  bool accept(char wanted);
  // Consumes the letters that start here and returns them.
  std::string_view word();

  // Consumes the longest number in SVG's syntax that starts here: "1.5.5" holds two, and so does "1-2". Returns nothing
  // and consumes nothing if there is no number, or one too large for a double. Returns 0 for one too small for a
  // double.
  std::optional<double> number();
  // Consumes a single 0 or 1, regardless of the character after it.
  std::optional<bool> flag();

 private:
  [[nodiscard]] std::size_t end_of_digits(std::size_t from) const;

  std::string_view text_;
  std::size_t at_ = 0;
};

std::string_view trimmed(std::string_view text);

}  // namespace kerf::svg
