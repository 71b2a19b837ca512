#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kerf::svg {

// Reads CSS from left to right. Comments count as blanks.
class CssScanner {
 public:
  explicit CssScanner(std::string_view text) : text_(text) {}

  [[nodiscard]] bool at_end() const { return at_ >= text_.size(); }
  [[nodiscard]] char peek() const { return at_end() ? '\0' : text_[at_]; }
  void step() { ++at_; }
  bool accept(char wanted);
  // Skips blanks and comments; returns true if there were any.
  bool skip_blanks();
  // Consumes an identifier, with its escapes resolved; empty if none starts here.
  std::string identifier();
  // Consumes a string in quotes; empty if none starts here.
  std::string quoted();
  // Consumes up to the first of `ends` outside brackets and strings, or to the end; returns what was before it.
  std::string_view until(std::string_view ends);

 private:
  [[nodiscard]] bool starts_identifier() const;
  void append_escape(std::string& to);

  std::string_view text_;
  std::size_t at_ = 0;
};

// Returns the text in lower case, as keywords are compared.
std::string lower(std::string_view text);

}  // namespace kerf::svg
