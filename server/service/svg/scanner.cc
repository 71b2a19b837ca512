#include "server/service/svg/scanner.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace kerf::svg {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

}  // namespace

bool Scanner::at_number() const {
  return is_digit(peek()) || peek() == '.' || peek() == '-' || peek() == '+';
}

void Scanner::skip_blanks() {
  while (!at_end() && is_blank(text_[at_])) ++at_;
}

bool Scanner::skip_separator() {
  skip_blanks();
  const bool comma = accept(',');
  if (comma) skip_blanks();
  return comma;
}

bool Scanner::accept(char wanted) {
  if (at_end() || text_[at_] != wanted) return false;
  ++at_;
  return true;
}

std::string_view Scanner::word() {
  const std::size_t from = at_;
  while (!at_end() && is_letter(text_[at_])) ++at_;
  return text_.substr(from, at_ - from);
}

std::size_t Scanner::end_of_digits(std::size_t from) const {
  while (from < text_.size() && is_digit(text_[from])) ++from;
  return from;
}

std::optional<double> Scanner::number() {
  const auto sign_at = [this](std::size_t at) { return at < text_.size() && (text_[at] == '-' || text_[at] == '+'); };
  std::size_t end = sign_at(at_) ? at_ + 1 : at_;
  const std::size_t first_digit = end;
  end = end_of_digits(end);
  std::size_t digits = end - first_digit;
  if (end < text_.size() && text_[end] == '.') {
    const std::size_t fraction = end_of_digits(end + 1);
    digits += fraction - end - 1;
    end = fraction;
  }
  if (digits == 0) return std::nullopt;
  bool tiny = false;  // Chooses between 0 and no result if the number is out of range.
  if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
    const std::size_t exponent = sign_at(end + 1) ? end + 2 : end + 1;
    const std::size_t exponent_end = end_of_digits(exponent);
    if (exponent_end > exponent) {  // Without digits the "e" begins a unit: "2em".
      tiny = text_[end + 1] == '-';
      end = exponent_end;
    }
  }
  const std::size_t from = text_[at_] == '+' ? at_ + 1 : at_;
  double value = 0.0;
  const auto [stop, fault] = std::from_chars(text_.data() + from, text_.data() + end, value);
  if (fault == std::errc::result_out_of_range) {
    if (!tiny) return std::nullopt;
    value = 0.0;
  } else if (fault != std::errc() || stop != text_.data() + end) {
    return std::nullopt;
  }
  at_ = end;
  return value;
}

std::optional<bool> Scanner::flag() {
  if (peek() != '0' && peek() != '1') return std::nullopt;
  return text_[at_++] == '1';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace kerf::svg
