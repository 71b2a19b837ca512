#pragma once

#include <string>
#include <string_view>

namespace kerf {

// Converts text to UTF-8 from an encoding that the C library knows.
class TextConverter {
 public:
  explicit TextConverter(const std::string& encoding);
  ~TextConverter();
  TextConverter(const TextConverter&) = delete;
  TextConverter& operator=(const TextConverter&) = delete;

  // Returns false if the library of this machine lacks the encoding; append() must not be called then.
  [[nodiscard]] bool is_known() const;

  // Appends the UTF-8 of the bytes; those without a meaning become U+FFFD.
  void append(std::string_view bytes, std::string& to);

 private:
  void* handle_;
};

}  // namespace kerf
