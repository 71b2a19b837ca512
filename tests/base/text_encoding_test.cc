// Text of files in UTF-8, UTF-16 and ISO-8859-1.

#include "server/base/text_encoding.h"

#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace kerf {
namespace {

using namespace std::string_literals;

TEST(TextEncoding, AByteOrderMarkIsPassedOver) {
  EXPECT_EQ(without_byte_order_mark("\xEF\xBB\xBFv 1"), "v 1");
  EXPECT_EQ(without_byte_order_mark("v 1"), "v 1");
  EXPECT_EQ(without_byte_order_mark("\xEF\xBBv"), "\xEF\xBBv");
  EXPECT_EQ(without_byte_order_mark(""), "");
  EXPECT_EQ(utf8_text("\xEF\xBB\xBFGr\xC3\xB6\xC3\x9F"
                      "e"),
            "Gr\xC3\xB6\xC3\x9F"
            "e");
}

TEST(TextEncoding, Utf16IsConvertedInBothByteOrders) {
  EXPECT_EQ(utf8_text("\xFF\xFEv\0 \0\xF6\0\n\0"s), "v \xC3\xB6\n");
  EXPECT_EQ(utf8_text("\xFE\xFF\0v\0 \0\xF6\0\n"s), "v \xC3\xB6\n");
  EXPECT_EQ(utf8_text("\xFF\xFE\x3D\xD8\x00\xDE\xAC\x20"s), "\xF0\x9F\x98\x80\xE2\x82\xAC");
  EXPECT_EQ(utf8_text("\xFF\xFE\x3D\xD8v\0\x00\xDEq"s), "\xEF\xBF\xBDv\xEF\xBF\xBD");
  EXPECT_EQ(utf8_text("\xFF\xFE"), "");
}

TEST(TextEncoding, LongTextIsShortenedByWholeCharacters) {
  EXPECT_EQ(shortened("abc", 3), "abc");
  EXPECT_EQ(shortened("abcd", 3), "abc...");
  EXPECT_EQ(shortened("ab\xC3\xA4", 3), "ab...") << "not half of a character";
  EXPECT_EQ(shortened("\xC3\xA4", 1), "...");
  EXPECT_EQ(shortened("", 0), "");
}

TEST(TextEncoding, OtherBytesAreLatin1) {
  EXPECT_EQ(utf8_text("Gr\xF6\xDF"
                      "e"),
            "Gr\xC3\xB6\xC3\x9F"
            "e");
  EXPECT_EQ(utf8_of_latin1("\xFF\x80"), "\xC3\xBF\xC2\x80");
}

TEST(TextEncoding, Utf8IsCheckedAsUnicodeDefinesIt) {
  for (const std::string_view good : {"", "a", "\xC2\x80", "\xDF\xBF", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80",
                                      "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF"}) {
    EXPECT_TRUE(is_utf8(good)) << good;
  }
  for (const std::string_view bad : {"\x80", "\xC1\xBF", "\xC2", "\xC2\x7F", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xE2\x82",
                                     "\xF0\x8F\xBF\xBF", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "a\xFF"}) {
    EXPECT_FALSE(is_utf8(bad)) << bad;
  }
}

}  // namespace
}  // namespace kerf
