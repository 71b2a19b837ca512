// Texts of DXF files in the code pages that their headers name.

#include "server/service/dxf/code_page.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/service/dxf/dxf.h"

namespace kerf::dxf {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string with_layer(const std::string& code_page, const std::string& layer) {
  const std::string header =
      code_page.empty() ? "" : "0\nSECTION\n2\nHEADER\n9\n$DWGCODEPAGE\n  3\n" + code_page + "\n0\nENDSEC\n";
  return header + "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n" + layer + "\n10\n0\n20\n0\n11\n1\n21\n0\n0\nENDSEC\n0\nEOF\n";
}

std::string layer_of(const std::string& code_page, const std::string& layer) {
  const Result<drawing::Drawing> drawing = read(with_layer(code_page, layer));
  EXPECT_TRUE(drawing.ok());
  EXPECT_THAT(drawing->not_cut, IsEmpty());
  return drawing->groups.at(0).selector;
}

TEST(DxfCodePage, OfTheHeaderIsRead) {
  EXPECT_EQ(layer_of("ANSI_1252", "Gr\xf6\xdf"), "layer=Gr\xc3\xb6\xc3\x9f");
  EXPECT_EQ(layer_of("ANSI_1251", "\xd0\xe5\xe7"), "layer=\xd0\xa0\xd0\xb5\xd0\xb7");
  EXPECT_EQ(layer_of("ansi_1250", "\xf8zz"), "layer=\xc5\x99zz");
  EXPECT_EQ(layer_of("DOS866", "\x90\xa5\xa7"), "layer=\xd0\xa0\xd0\xb5\xd0\xb7");
  EXPECT_EQ(layer_of("ANSI_932", "\x90\xd8"), "layer=\xe5\x88\x87");
  EXPECT_EQ(layer_of("GB2312", "\xc7\xd0"), "layer=\xe5\x88\x87");
  EXPECT_EQ(layer_of("BIG5", "\xa4\xc1"), "layer=\xe5\x88\x87");
  EXPECT_EQ(layer_of("iso8859-5", "\xc0\xd5"), "layer=\xd0\xa0\xd0\xb5");
  // Bytes that are UTF-8 are that, whatever an old header says.
  EXPECT_EQ(layer_of("ANSI_1251", "\xc3\xb6"), "layer=\xc3\xb6");
  EXPECT_EQ(layer_of("none", "Cut"), "layer=Cut");
  // A byte without a meaning does not end the text.
  EXPECT_EQ(layer_of("ANSI_1252", "a\x81z"), "layer=a\xef\xbf\xbdz");
}

TEST(DxfCodePage, ThatIsNotReadIsNamed) {
  EXPECT_THAT(read(with_layer("ANSI_777", "Gr\xf6\xdf"))->not_cut,
              ElementsAre("DXF: code page ANSI_777: names are taken as ISO-8859-1, and may be wrong"));
  EXPECT_THAT(
      read(with_layer("", "Gr\xf6\xdf"))->not_cut,
      ElementsAre("DXF: code page that the file does not name: names are taken as ISO-8859-1, and may be wrong"));
}

TEST(DxfCodePage, EscapesNameTheirs) {
  EXPECT_EQ(layer_of("ANSI_1252", "\\M+190D8"), "layer=\xe5\x88\x87");
  EXPECT_EQ(layer_of("", "a\\M+2a4c1b\\M+5C7D0"),
            "layer=a\xe5\x88\x87"
            "b\xe5\x88\x87");
  EXPECT_EQ(layer_of("", "\\M+10041"), "layer=A");
  EXPECT_EQ(layer_of("", "\\M+99999\\M+1zzzz\\M+1"), "layer=\\M+99999\\M+1zzzz\\M+1");
}

TEST(DxfCodePage, LongTextsAreWhole) {
  std::string data = "9\n$DWGCODEPAGE\n3\nANSI_1251\n";
  std::string text = data;
  for (int i = 0; i < 10'000; ++i) {
    data += i % 7 == 0 ? "\x98" : "\xd0";
    text += i % 7 == 0 ? "\xef\xbf\xbd" : "\xd0\xa0";
  }
  EXPECT_EQ(decoded(data).text, text);
}

}  // namespace
}  // namespace kerf::dxf
