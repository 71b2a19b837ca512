#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

// Splits the text of mesh files into lines, words and numbers.
namespace kerf::mesh {

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

// Removes the next word from the front of `line` and returns it. Returns an empty word at the end of the line.
inline std::string_view next_token(std::string_view& line) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  std::size_t length = 0;
  while (length < line.size() && !is_blank(line[length])) ++length;
  const std::string_view word = line.substr(0, length);
  line.remove_prefix(length);
  return word;
}

// Removes the next line from the front of `text`, which is not empty. Returns the line without its end character.
inline std::string_view next_line(std::string_view& text, char end) {
  const std::size_t length = std::min(text.find(end), text.size());
  const std::string_view line = text.substr(0, length);
  text.remove_prefix(std::min(length + 1, text.size()));
  return line;
}

// Parses a number of this type, with or without a sign; returns true if it is the whole word.
template <typename Number>
bool parse_number(std::string_view word, Number& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  return code == std::errc{} && end == word.data() + word.size() && !word.empty();
}

// Parses a coordinate. Words such as nan, inf, 1e999 and 1.#QNAN are numbers too, and give what is not finite; 1.5D-2
// is 0.015, as Fortran writes it.
inline bool parse_coordinate(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  const std::string_view rest(end, static_cast<std::size_t>(word.data() + word.size() - end));
  if (word.empty() || end == word.data()) return false;
  if (code == std::errc{} && rest.empty()) return true;
  if (rest.size() > 1 && (rest.front() == 'd' || rest.front() == 'D')) {
    std::string with_e(word);
    with_e[word.size() - rest.size()] = 'e';
    return parse_number(with_e, value);
  }
  const bool is_tiny = word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos;
  value = is_tiny ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  return (code == std::errc::result_out_of_range && rest.empty()) || rest.starts_with("#");
}

// Returns a word in quotes, for messages: at most 40 characters, with ? for those that are not printable ASCII.
inline std::string quoted(std::string_view word) {
  std::string shown = "\"";
  for (const char c : word.substr(0, 40)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (word.size() > 40 ? "...\"" : "\"");
}

}  // namespace kerf::mesh
