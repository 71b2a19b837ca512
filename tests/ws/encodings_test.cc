// Encodings of the viewer's files: the choice by Accept-Encoding, and the headers.

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>

#include "server/service/ws/asset_table.h"
#include "server/service/ws/header_list.h"
#include "tests/ws/http_fixture.h"

namespace kerf::ws_test {
namespace {

TEST(HeaderList, NamesTokens) {
  EXPECT_TRUE(ws::lists_token("kerf.v1", "kerf.v1"));
  EXPECT_TRUE(ws::lists_token("mqtt, KERF.v1 ,other", "kerf.v1"));
  EXPECT_FALSE(ws::lists_token("", "kerf.v1"));
  EXPECT_FALSE(ws::lists_token("kerf.v10, xkerf.v1, kerf v1", "kerf.v1"));
}

TEST(HeaderList, WeighsCodings) {
  EXPECT_EQ(ws::coding_quality("gzip, br", "br"), 1.0);
  EXPECT_EQ(ws::coding_quality("gzip;q=0.5 , BR ; Q=0.25", "br"), 0.25);
  EXPECT_EQ(ws::coding_quality("gzip", "br"), 0.0);
  EXPECT_EQ(ws::coding_quality("*;q=0.5, gzip;q=0", "br"), 0.5);
  EXPECT_EQ(ws::coding_quality("*;q=0.5, gzip;q=0", "gzip"), 0.0);
  EXPECT_EQ(ws::coding_quality("", "gzip"), 0.0);
  EXPECT_EQ(ws::coding_quality("xbr, brx, br2", "br"), 0.0);
  EXPECT_GT(ws::coding_quality("", "identity"), 0.0);
  EXPECT_LT(ws::coding_quality("gzip", "identity"), ws::coding_quality("gzip;q=0.001", "gzip"));
  EXPECT_EQ(ws::coding_quality("*;q=0", "identity"), 0.0);
  for (const char* malformed : {"br;q=", "br;q=2", "br;q=-1", "br;q=x", "br;q=0.5x", "br;q=nan", "br;quality=1"}) {
    EXPECT_EQ(ws::coding_quality(malformed, "br"), 0.0) << malformed;
  }
}

TEST(HeaderList, ChoosesTheCodingWantedMost) {
  constexpr std::array<std::string_view, 2> kCodings{"br", "gzip"};
  struct Case {
    std::string_view header;
    std::string_view coding;
  };
  for (const auto& [header, coding] : {Case{"gzip, deflate, br, zstd", "br"},
                                       {"gzip, deflate", "gzip"},
                                       {"", "identity"},
                                       {"deflate", "identity"},
                                       {"*", "br"},
                                       {"br;q=0, *", "gzip"},
                                       {"br;q=0, gzip;q=0, *", "identity"},
                                       {"br;q=0.5, gzip", "gzip"},
                                       {"br;q=0.001", "br"},
                                       {"identity, br;q=0.9", "identity"},
                                       {"identity, br", "br"},
                                       {"identity;q=0, gzip;q=0.1", "gzip"},
                                       {"*;q=0", "identity"}}) {
    EXPECT_EQ(ws::best_coding(header, kCodings), coding) << header;
  }
}

class EncodedFilesTest : public HttpServerTest {
 protected:
  static constexpr const char* kScript = "/assets/app-12.js";

  // Writes a file `age` after the one that it encodes.
  void write_encoded(const std::string& name, const std::string& content, std::chrono::seconds age = {}) const {
    const fs::path file = folder_.write("viewer/" + name, content);
    const fs::path original = file.parent_path() / file.stem();
    if (fs::exists(original)) fs::last_write_time(file, fs::last_write_time(original) + age);
  }
  [[nodiscard]] Response get_as(std::string_view accepted, std::string_view more = {}) const {
    return get(kScript, "Accept-Encoding: " + std::string(accepted) + "\r\n" + std::string(more));
  }
};

TEST_F(EncodedFilesTest, TheFileThatTheClientWantsMostIsSent) {
  write_encoded("assets/app-12.js.br", "as br");
  write_encoded("assets/app-12.js.gz", "as gzip");
  start();
  const Response brotli = get_as("gzip, deflate, br");
  EXPECT_EQ(brotli.body, "as br");
  EXPECT_EQ(brotli.headers.at("content-encoding"), "br");
  const Response gzip = get_as("br;q=0, gzip");
  EXPECT_EQ(gzip.body, "as gzip");
  EXPECT_EQ(gzip.headers.at("content-encoding"), "gzip");
  for (const Response& plain : {get(kScript), get_as("identity"), get_as("*;q=0")}) {
    EXPECT_EQ(plain.body, "let viewer;");
    EXPECT_FALSE(plain.headers.contains("content-encoding"));
    EXPECT_EQ(plain.headers.at("vary"), "Accept-Encoding");
  }
  for (const Response& encoded : {brotli, gzip}) {
    EXPECT_EQ(encoded.headers.at("vary"), "Accept-Encoding");
    EXPECT_EQ(encoded.headers.at("content-type"), "text/javascript; charset=utf-8");
    EXPECT_NE(encoded.headers.at("cache-control").find("immutable"), std::string::npos);
  }
  EXPECT_EQ(get("/assets/app-12.js.br").status, 404);
  EXPECT_EQ(get("/assets/app-12.js.gz").status, 404);
}

TEST_F(EncodedFilesTest, EachEncodingHasATagOfItsOwn) {
  write_encoded("assets/app-12.js.br", "as br");
  write_encoded("assets/app-12.js.gz", "as gzip");
  start();
  const std::string plain = get(kScript).headers.at("etag");
  const std::string gzip = get_as("gzip").headers.at("etag");
  const std::string brotli = get_as("br").headers.at("etag");
  EXPECT_NE(plain, gzip);
  EXPECT_NE(plain, brotli);
  EXPECT_NE(gzip, brotli);
  const Response unchanged = get_as("br", "If-None-Match: " + brotli + "\r\n");
  EXPECT_EQ(unchanged.status, 304);
  EXPECT_TRUE(unchanged.body.empty());
  EXPECT_EQ(unchanged.headers.at("vary"), "Accept-Encoding");
  EXPECT_EQ(unchanged.headers.at("etag"), brotli);
  EXPECT_EQ(get_as("br", "If-None-Match: " + plain + "\r\n").body, "as br");
  EXPECT_EQ(get_as("gzip", "If-None-Match: " + plain + ", " + gzip + "\r\n").status, 304);
}

TEST_F(EncodedFilesTest, HeadTellsTheEncodingsLengthAndRangesAreIgnored) {
  write_encoded("assets/app-12.js.gz", "as gzip");
  start();
  const Response head = request(port_, "HEAD", kScript, "Accept-Encoding: gzip\r\n");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-length"), "7");
  EXPECT_EQ(head.headers.at("content-encoding"), "gzip");
  EXPECT_EQ(head.headers.at("etag"), get_as("gzip").headers.at("etag"));
  const Response part = get_as("gzip", "Range: bytes=0-1\r\n");
  EXPECT_EQ(part.status, 200);
  EXPECT_EQ(part.body, "as gzip");
  EXPECT_EQ(part.headers.at("accept-ranges"), "none");
  EXPECT_FALSE(part.headers.contains("content-range"));
}

TEST_F(EncodedFilesTest, AnEncodingOlderThanItsFileIsNotSent) {
  write_encoded("assets/app-12.js.br", "as an older br", std::chrono::seconds(-1));
  write_encoded("assets/app-12.js.gz", "as gzip");
  start();
  EXPECT_EQ(get_as("br").body, "let viewer;");
  EXPECT_EQ(get_as("br, gzip").body, "as gzip");
  EXPECT_EQ(get("/assets/app-12.js.br").status, 404);
}

TEST_F(EncodedFilesTest, AFileWithoutAnyGoesAsItIs) {
  write_encoded("assets/scan.gz", "a file of its own");
  start();
  const Response index = get("/", "Accept-Encoding: br, gzip\r\n");
  EXPECT_EQ(index.body, "<p>viewer</p>");
  EXPECT_FALSE(index.headers.contains("content-encoding"));
  EXPECT_FALSE(index.headers.contains("vary"));
  EXPECT_EQ(get("/assets/scan.gz").body, "a file of its own");
}

}  // namespace
}  // namespace kerf::ws_test
