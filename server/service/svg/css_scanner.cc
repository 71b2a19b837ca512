#include "server/service/svg/css_scanner.h"

#include <algorithm>
#include <cstdint>

namespace kerf::svg {
namespace {

bool is_css_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f';
}

// True for characters within names; all beyond ASCII are.
bool is_name_character(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
         byte >= 0x80;
}

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

void append_utf8(std::uint32_t code, std::string& to) {
  if (code == 0 || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) code = 0xfffd;
  if (code < 0x80) {
    to += static_cast<char>(code);
  } else if (code < 0x800) {
    to += static_cast<char>(0xc0U | code >> 6U);
    to += static_cast<char>(0x80U | (code & 0x3fU));
  } else {
    if (code < 0x10000) {
      to += static_cast<char>(0xe0U | code >> 12U);
    } else {
      to += static_cast<char>(0xf0U | code >> 18U);
      to += static_cast<char>(0x80U | (code >> 12U & 0x3fU));
    }
    to += static_cast<char>(0x80U | (code >> 6U & 0x3fU));
    to += static_cast<char>(0x80U | (code & 0x3fU));
  }
}

}  // namespace

bool CssScanner::accept(char wanted) {
  if (at_end() || text_[at_] != wanted) return false;
  ++at_;
  return true;
}

bool CssScanner::skip_blanks() {
  const std::size_t from = at_;
  while (!at_end()) {
    if (is_css_blank(text_[at_])) {
      ++at_;
    } else if (text_.substr(at_, 2) == "/*") {
      const std::size_t end = text_.find("*/", at_ + 2);
      at_ = end == std::string_view::npos ? text_.size() : end + 2;
    } else if (text_.substr(at_, 4) == "<!--") {
      at_ += 4;
    } else if (text_.substr(at_, 3) == "-->") {
      at_ += 3;
    } else {
      break;
    }
  }
  return at_ > from;
}

bool CssScanner::starts_identifier() const {
  const char c = peek();
  if (c >= '0' && c <= '9') return false;
  if (c == '\\') return at_ + 1 < text_.size() && text_[at_ + 1] != '\n';
  return is_name_character(c) && text_.substr(at_, 3) != "-->";
}

void CssScanner::append_escape(std::string& to) {
  ++at_;  // The backslash.
  if (at_end()) return;
  if (hex_value(text_[at_]) < 0) {
    to += text_[at_++];
    return;
  }
  std::uint32_t code = 0;
  for (int i = 0; i < 6 && !at_end() && hex_value(text_[at_]) >= 0; ++i) {
    code = code * 16 + static_cast<std::uint32_t>(hex_value(text_[at_++]));
  }
  if (!at_end() && is_css_blank(text_[at_])) ++at_;
  append_utf8(code, to);
}

std::string CssScanner::identifier() {
  std::string name;
  if (!starts_identifier()) return name;
  while (!at_end()) {
    if (text_[at_] == '\\') {
      append_escape(name);
    } else if (is_name_character(text_[at_])) {
      name += text_[at_++];
    } else {
      break;
    }
  }
  return name;
}

std::string CssScanner::quoted() {
  std::string value;
  const char quote = peek();
  if (quote != '"' && quote != '\'') return value;
  ++at_;
  while (!at_end() && text_[at_] != quote) {
    if (text_[at_] == '\\') {
      append_escape(value);
    } else {
      value += text_[at_++];
    }
  }
  if (!at_end()) ++at_;
  return value;
}

std::string_view CssScanner::until(std::string_view ends) {
  const std::size_t from = at_;
  std::string closing;  // Closing brackets that are awaited, the last one first.
  while (!at_end()) {
    const char c = text_[at_];
    if (closing.empty() && ends.find(c) != std::string_view::npos) break;
    if (c == '"' || c == '\'') {
      quoted();
      continue;
    }
    if (text_.substr(at_, 2) == "/*") {
      skip_blanks();
      continue;
    }
    if (c == '\\') ++at_;
    if (c == '(' || c == '[' || c == '{') closing += c == '(' ? ')' : c == '[' ? ']' : '}';
    if (!closing.empty() && c == closing.back()) closing.pop_back();
    ++at_;
  }
  at_ = std::min(at_, text_.size());
  return text_.substr(from, at_ - from);
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

}  // namespace kerf::svg
