// Files as they are stored: encodings, byte order marks, compression and embedded pictures.

#include "server/service/svg/text.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "tests/svg/drawn.h"

namespace kerf::svg {
namespace {

const std::string kBody =
    R"svg(<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><rect id="Gr@e" width="2" height="3"/></svg>)svg";

std::string with_id(std::string text, const std::string& letters) {
  return text.replace(text.find('@'), 1, letters);
}

std::string utf16(const std::string& ascii, bool big_endian) {
  std::string text;
  for (const char c : ascii) {
    if (big_endian) text += '\0';
    text += c == '@' ? '\xf6' : c;
    if (!big_endian) text += '\0';
  }
  return text;
}

std::string gzipped(const std::string& text) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string result(text.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

// Reads with the id chosen, which tells that the letter was understood.
void expect_read(const std::string& data) {
  drawing::Reading reading;
  reading.only = {
      "#Gr\xc3\xb6"
      "e"};
  const Result<Drawing> drawing = read_all(data, reading);
  ASSERT_TRUE(drawing.ok()) << drawing.error().message;
  EXPECT_EQ(drawing->path.subpaths.size(), 1U);
}

TEST(SvgText, Encodings) {
  expect_read(with_id(kBody, "\xc3\xb6"));
  expect_read("\xef\xbb\xbf" + with_id(kBody, "\xc3\xb6"));
  expect_read("\xef\xbb\xbf<?xml version=\"1.0\" encoding=\"utf-8\"?>" + with_id(kBody, "\xc3\xb6"));
  expect_read("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>" + with_id(kBody, "\xf6"));
  expect_read("<?xml version='1.0' encoding='windows-1252'?>" + with_id(kBody, "\xf6"));
  expect_read(with_id(kBody, "\xf6"));
  expect_read("\xff\xfe" + utf16(kBody, false));
  expect_read("\xfe\xff" + utf16("<?xml version=\"1.0\" encoding=\"UTF-16\"?>" + kBody, true));
  expect_read(utf16(kBody, false));
  expect_read(utf16(kBody, true));
}

// Clients convert a file before they send it, and its declaration still names the encoding that it had.
TEST(SvgText, ConvertedTextIsNotConvertedAgain) {
  const std::string declared = "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>" + with_id(kBody, "\xf6");
  const std::string once = text_of(declared);
  EXPECT_NE(once, declared);
  EXPECT_EQ(text_of(once), once);
  expect_read(once);
}

TEST(SvgText, Gzip) {
  const std::string packed = gzipped(with_id(kBody, "\xc3\xb6"));
  expect_read(packed);
  expect_read(gzipped("\xff\xfe" + utf16(kBody, false)));
  EXPECT_EQ(read_all(packed.substr(0, packed.size() / 2)).error().reason, "SVG_MALFORMED");
  EXPECT_THAT(read_all(gzipped(packed)).error().message, testing::HasSubstr("compressed twice"));
  EXPECT_EQ(read_all(gzipped(kBody + std::string(kMaxTextBytes, ' '))).error().reason, "SVG_TOO_LARGE");
  EXPECT_EQ(read_all(gzipped(std::string(kMaxFileBytes + 1, ' '))).error().reason, "SVG_TOO_LARGE");
}

TEST(SvgText, OtherFilesAreNamed) {
  const auto says = [](const std::string& text) { return read_all(text).error().message; };
  EXPECT_EQ(says(""), "the file is empty");
  EXPECT_EQ(says(" \n"), "the file is empty");
  EXPECT_EQ(says("%PDF-1.4\n"), "the file is a PDF; a drawing is SVG or DXF");
  EXPECT_EQ(says("v 0 0 0\n"), "the file is a mesh (OBJ); a drawing is SVG or DXF");
  EXPECT_EQ(says("\x89PNG\r\n"), "the file is a picture (PNG); a drawing is SVG or DXF");
  EXPECT_EQ(says("G21 ; mm\nG0 X1"), "the file is neither SVG nor DXF: it begins with \"G21 ; mm\"");
  EXPECT_EQ(says("  0\nSECTION\n"), "the file is DXF, and this reads SVG");
  EXPECT_THAT(says("<svg><g></svg>"), testing::HasSubstr("line 1: not XML"));
}

TEST(SvgText, EmbeddedDataDoesNotCount) {
  const std::string picture(700'000, 'A');
  const std::string rect = R"svg(<rect width="2" height="3"/>)svg";
  for (const std::string& embedded :
       {"<image width=\"5\" href=\"data:image/png;base64," + picture + "\"/>",
        "<image xlink:href='data:image/jpeg;base64," + picture + "'/>",
        "<image xlink:href=\" \ndata:image/png;base64," + picture + "\"/>",
        "<style>@font-face{src:url(data:font/woff;base64," + picture + ")}</style>",
        "<style>@font-face{src:url(\"data:font/woff;base64," + picture + "\")}</style>"}) {
    const Result<Drawing> drawing = read_all(document(embedded + rect));
    ASSERT_TRUE(drawing.ok()) << embedded.substr(0, 60) << drawing.error().message;
    EXPECT_EQ(drawing->path.subpaths.size(), 1U);
  }
  EXPECT_EQ(read_all(document("<text>" + picture + "</text>" + rect)).error().reason, "SVG_TOO_LARGE");
  EXPECT_EQ(read_all(document("<text>data:" + picture + "</text>" + rect)).error().reason, "SVG_TOO_LARGE");
  EXPECT_EQ(read_all(document(std::string(kMaxFileBytes, ' '))).error().reason, "SVG_TOO_LARGE");
  EXPECT_EQ(without_embedded_data("a=\"data:x\" b='data:' c=\"data:unended"), "a=\"data:\" b='data:' c=\"data:unended");
}

}  // namespace
}  // namespace kerf::svg
