#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace kerf::svg {

// Reads the small languages inside attributes, from left to right.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  [[nodiscard]] bool at_end() const { return at_ == text_.size(); }
  [[nodiscard]] std::size_t position() const { return at_; }
  [[nodiscard]] char peek() const { return at_end() ? '\0' : text_[at_]; }
  // Whether a number can start here.
  [[nodiscard]] bool at_number() const;

  void skip_blanks();
  // Blanks with at most one comma among them; whether there was one.
  bool skip_separator();
  // The next character if it is this one.
  bool accept(char wanted);
  // Letters, as many as there are.
  std::string_view word();

  // A number in SVG's syntax: the longest that starts here, so that "1.5.5" is two and "1-2" as well. Nothing, and no
  // step forward, where there is none or where it is too large for a double; too small for one is 0.
  std::optional<double> number();
  // A single 0 or 1, whatever follows it.
  std::optional<bool> flag();

 private:
  [[nodiscard]] std::size_t end_of_digits(std::size_t from) const;

  std::string_view text_;
  std::size_t at_ = 0;
};

std::string_view trimmed(std::string_view text);

}  // namespace kerf::svg
