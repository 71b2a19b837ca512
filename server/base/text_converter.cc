#include "server/base/text_converter.h"

#include <array>
#include <cerrno>
#include <cstddef>

#include <iconv.h>

namespace kerf {
namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";

iconv_t unknown() {
  return reinterpret_cast<iconv_t>(-1);
}

}  // namespace

TextConverter::TextConverter(const std::string& encoding) : handle_(iconv_open("UTF-8", encoding.c_str())) {}

TextConverter::~TextConverter() {
  if (is_known()) iconv_close(handle_);
}

bool TextConverter::is_known() const {
  return handle_ != unknown();
}

void TextConverter::append(std::string_view bytes, std::string& to) {
  std::array<char, 4096> room{};
  iconv(handle_, nullptr, nullptr, nullptr, nullptr);
  // The interface predates const; it does not write to its input.
  char* from = const_cast<char*>(bytes.data());
  std::size_t left = bytes.size();
  while (left > 0) {
    char* out = room.data();
    std::size_t free = room.size();
    const bool is_done = iconv(handle_, &from, &left, &out, &free) != static_cast<std::size_t>(-1);
    const bool is_full = !is_done && errno == E2BIG;
    to.append(room.data(), room.size() - free);
    if (is_done || is_full) continue;
    to += kReplacement;
    ++from;
    --left;
  }
}

}  // namespace kerf
