// Text in encodings that the C library knows.

#include "server/base/text_converter.h"

#include <string>

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(TextConverter, KeepsWhatHasAMeaning) {
  TextConverter converter("CP932");
  ASSERT_TRUE(converter.is_known());
  std::string text = "a";
  converter.append("\x90\xd8\xa0z\x90", text);
  converter.append("", text);
  converter.append("b", text);
  EXPECT_EQ(text,
            "a\xe5\x88\x87\xef\xbf\xbdz\xef\xbf\xbd"
            "b");
}

TEST(TextConverter, SaysThatAnEncodingIsUnknown) {
  EXPECT_FALSE(TextConverter("CP777").is_known());
}

}  // namespace
}  // namespace kerf
