#pragma once

#include <string>
#include <string_view>

// Brings text of files to UTF-8, whatever program wrote them.
namespace kerf {

// Returns the text without the byte order mark of UTF-8, if it begins with one.
std::string_view without_byte_order_mark(std::string_view text);

// Returns true if all bytes are well-formed UTF-8: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view text);

// Returns a UTF-8 text of at most `max_bytes`; of a longer one its beginning, up to a whole character, with "..." after
// it.
std::string shortened(std::string_view text, std::size_t max_bytes);

// Returns the UTF-8 of text in ISO-8859-1, where each byte is one character.
std::string utf8_of_latin1(std::string_view text);

// Returns a file's text as UTF-8 without a byte order mark. UTF-16 is known by its mark, of either byte order; a
// surrogate without its partner becomes U+FFFD. Other bytes are UTF-8 if they are well-formed, else ISO-8859-1.
std::string utf8_text(std::string file);

}  // namespace kerf
