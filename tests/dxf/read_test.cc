// DXF drawings: outlines of entities and blocks, layers and colours, units, and what is reported or refused.

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/fit.h"
#include "server/service/drawing/arc_length.h"
#include "server/service/drawing/inflate.h"
#include "server/service/drawing/placing.h"
#include "server/service/dxf/colours.h"
#include "server/service/dxf/dxf.h"

namespace kerf::dxf {
namespace {

using Eigen::Vector2d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Writes groups separated by blanks, "0 LINE 10 1.5", one to two lines.
std::string groups(const std::string& words) {
  std::string text;
  std::string word;
  for (const char c : words + " ") {
    if (c != ' ' && c != '\n') {
      word += c;
    } else if (!word.empty()) {
      for (char& each : word) each = each == '~' ? ' ' : each;
      text += word + "\n";
      word.clear();
    }
  }
  return text;
}

// A file with entities; lengths are in metres.
std::string file(const std::string& entities, const std::string& before = "") {
  return groups("0 SECTION 2 HEADER 9 $ACADVER 1 AC1027 9 $INSUNITS 70 6 0 ENDSEC " + before +
                " 0 SECTION 2 ENTITIES " + entities + " 0 ENDSEC 0 EOF");
}

std::string layers(const std::string& entries) {
  return "0 SECTION 2 TABLES 0 TABLE 2 LAYER " + entries + " 0 ENDTAB 0 ENDSEC";
}

std::string line_to_one() {
  return "0 LINE 8 0 10 0 20 0 11 1 21 0";
}

struct Cut {
  cut::Path path;
  std::vector<std::string> notes;
};
Result<Cut> read_all(const std::string& text, const drawing::Reading& reading = {}) {
  KERF_TRY_ASSIGN(const drawing::Drawing drawing, read(text, reading.unit));
  KERF_TRY_ASSIGN(drawing::Placed placed, drawing::place(drawing, reading, "DXF", "cut.curve.dxf"));
  return Cut{std::move(placed.path), std::move(placed.notes)};
}
Cut cut_of(const std::string& text, const drawing::Reading& reading = {}) {
  Result<Cut> done = read_all(text, reading);
  EXPECT_TRUE(done.ok()) << text << done.error().message;
  return done.ok() ? *done : Cut{};
}

void expect_extent(const Cut& drawn, const Eigen::Vector4d& box) {
  const cut::Box found = cut::extent(drawn.path);
  const Eigen::Vector4d all(found.low.x(), found.low.y(), found.high.x(), found.high.y());
  EXPECT_LT((all - box).cwiseAbs().maxCoeff(), 1e-9) << all.transpose();
}
void expect_extent(const std::string& entities, const Eigen::Vector4d& box) {
  SCOPED_TRACE(entities);
  expect_extent(cut_of(file(entities)), box);
}
double length_of(const std::string& entities) {
  double length = 0.0;
  for (const cut::Subpath& line : cut_of(file(entities)).path.subpaths) length += drawing::length_of(line);
  return length;
}

constexpr double kPi = 3.14159265358979;

TEST(DxfRead, Entities) {
  expect_extent("0 LINE 8 0 10 1 20 2 11 3 21 5", {1, 2, 3, 5});
  expect_extent("0 CIRCLE 8 0 10 1 20 2 40 3", {-2, -1, 4, 5});
  expect_extent("0 ARC 8 0 10 0 20 0 40 2 50 0 51 90", {0, 0, 2, 2});
  expect_extent("0 ARC 8 0 10 0 20 0 40 2 50 270 51 90", {0, -2, 2, 2});
  expect_extent("0 ARC 8 0 10 0 20 0 40 2 50 90 51 0", {-2, -2, 2, 2});
  expect_extent("0 ELLIPSE 8 0 10 1 20 1 11 0 21 3 40 0.5", {-0.5, -2, 2.5, 4});
  expect_extent("0 ELLIPSE 8 0 10 0 20 0 11 2 21 0 40 0.5 41 0 42 1.5707963267949", {0, 0, 2, 1});
  expect_extent("0 LWPOLYLINE 8 0 90 3 70 0 10 0 20 0 10 4 20 0 10 4 20 3", {0, 0, 4, 3});
  expect_extent(
      "0 POLYLINE 8 0 66 1 70 1 0 VERTEX 8 0 10 0 20 0 0 VERTEX 8 0 10 4 20 0 0 VERTEX 8 0 10 4 20 3 0 SEQEND",
      {0, 0, 4, 3});
  expect_extent("0 SPLINE 8 0 71 2 72 6 73 3 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 10 1 20 2 10 2 20 0",
                {0, 0, 2, 1});
  expect_extent("0 SPLINE 8 0 71 3 74 3 11 0 21 0 11 1 21 0 11 2 21 0", {0, 0, 2, 0});
  EXPECT_NEAR(length_of("0 ARC 8 0 10 0 20 0 40 1 50 350 51 10"), kPi / 9.0, 1e-6);
  EXPECT_TRUE(cut_of(file("0 CIRCLE 8 0 10 1 20 2 40 3")).path.subpaths[0].closed);
  EXPECT_FALSE(cut_of(file("0 LWPOLYLINE 8 0 70 0 10 0 20 0 10 4 20 0")).path.subpaths[0].closed);
}

TEST(DxfRead, BulgesAreArcs) {
  // A bulge of 1 is a half circle to the right of the way, seen from the start; counter-clockwise about its middle.
  expect_extent("0 LWPOLYLINE 8 0 70 0 10 0 20 0 42 1 10 2 20 0", {0, -1, 2, 0});
  expect_extent("0 LWPOLYLINE 8 0 70 0 10 0 20 0 42 -1 10 2 20 0", {0, 0, 2, 1});
  // Two halves make a circle; the second one closes it.
  EXPECT_NEAR(length_of("0 LWPOLYLINE 8 0 70 1 10 0 20 0 42 1 10 2 20 0 42 1"), 2.0 * kPi, 1e-6);
  EXPECT_NEAR(length_of("0 LWPOLYLINE 8 0 70 0 10 0 20 0 42 0.41421356237309503 10 1 20 1"), 0.5 * kPi, 1e-6);
  // Three quarters of a circle.
  EXPECT_NEAR(length_of("0 LWPOLYLINE 8 0 70 0 10 0 20 0 42 2.414213562373095 10 1 20 1"), 1.5 * kPi, 1e-6);
  EXPECT_NEAR(length_of("0 POLYLINE 8 0 66 1 0 VERTEX 10 0 20 0 42 1 0 VERTEX 10 2 20 0 0 SEQEND"), kPi, 1e-6);
}

TEST(DxfRead, MirroredPlanes) {
  expect_extent("0 CIRCLE 8 0 10 5 20 2 40 1 210 0 220 0 230 -1", {-6, 1, -4, 3});
  expect_extent("0 LWPOLYLINE 8 0 70 0 10 1 20 0 10 3 20 1 230 -1", {-3, 0, -1, 1});
  expect_extent("0 ARC 8 0 10 0 20 0 40 1 50 0 51 90 230 -1", {-1, 0, 0, 1});
  expect_extent("0 LINE 8 0 10 1 20 0 11 3 21 1 230 -1", {1, 0, 3, 1});  // Lines are in the drawing's own plane.
  expect_extent("0 ELLIPSE 8 0 10 0 20 0 11 2 21 0 40 0.5 41 0 42 1.5707963267949 230 -1", {0, -1, 2, 0});
  const Cut tilted = cut_of(file("0 CIRCLE 8 0 10 5 20 2 40 1 210 1 220 0 230 0 0 LINE 8 0 10 0 20 0 11 1 21 1"));
  EXPECT_THAT(tilted.notes, ElementsAre("DXF: 1 x entity that is not parallel to the plane of the drawing: not cut"));
}

TEST(DxfRead, Blocks) {
  const std::string blocks =
      "0 SECTION 2 BLOCKS 0 BLOCK 2 Part 10 1 20 1 0 LINE 8 0 62 0 10 1 20 1 11 3 21 1 0 LINE 8 Own 10 1 20 1 11 1 21 "
      "2 "
      "0 ENDBLK 0 BLOCK 2 Outer 10 0 20 0 0 INSERT 8 0 2 PART 10 0 20 0 0 ENDBLK "
      "0 BLOCK 2 Loop 10 0 20 0 0 INSERT 2 Loop 0 LINE 8 0 10 0 20 0 11 1 21 0 0 ENDBLK 0 ENDSEC";
  expect_extent(cut_of(file("0 INSERT 8 L 2 Part 10 0 20 0", blocks)), {0, 0, 2, 1});
  expect_extent(cut_of(file("0 INSERT 8 L 2 part 10 5 20 5 41 2 42 3 50 90", blocks)), {2, 5, 5, 9});
  expect_extent(cut_of(file("0 INSERT 8 L 2 Part 10 0 20 0 70 3 71 2 44 10 45 20", blocks)), {0, 0, 22, 21});
  expect_extent(cut_of(file("0 INSERT 8 L 2 Part 10 0 20 0 41 -1", blocks)), {-2, 0, 0, 1});
  expect_extent(cut_of(file("0 INSERT 8 L 2 Outer 10 7 20 0", blocks)), {7, 0, 9, 1});
  // An array is turned as a whole, and its steps are not scaled.
  expect_extent(cut_of(file("0 INSERT 8 L 2 Part 10 0 20 0 50 90 41 0.5 70 2 44 4", blocks)), {-1, 0, 0, 5});
  const Cut loop = cut_of(file("0 INSERT 8 L 2 Loop 10 0 20 0 0 INSERT 8 L 2 Nothing 10 0 20 0", blocks));
  EXPECT_THAT(loop.notes, ElementsAre("DXF: 1 x insertion of a block into itself: not cut",
                                      "DXF: 1 x insertion of a block that is missing: not cut"));
  // Entities on layer 0 in a block are on the layer of the insertion, and take its colour if they say so.
  drawing::Reading reading;
  reading.only = {"layer=L"};
  expect_extent(cut_of(file("0 INSERT 8 L 62 1 2 Part 10 0 20 0", blocks), reading), {0, 0, 2, 0});
  reading.only = {"stroke=red"};
  expect_extent(cut_of(file("0 INSERT 8 L 62 1 2 Part 10 0 20 0", blocks), reading), {0, 0, 2, 0});
  reading.only = {"layer=Own"};
  expect_extent(cut_of(file("0 INSERT 8 L 2 Part 10 0 20 0", blocks), reading), {0, 0, 0, 1});
}

TEST(DxfRead, LayersAndColours) {
  const std::string table = layers(
      "0 LAYER 2 Cut 70 0 62 1 6 CONTINUOUS 0 LAYER 2 Off 70 0 62 -3 0 LAYER 2 Frozen 70 1 62 5 "
      "0 LAYER 2 Fold~Lines 70 0 62 5 6 DASHED 0 LAYER 2 Gr\\U+00F6\\U+00DFe 70 0 62 7");
  const std::string text = file(
      "0 LINE 8 Cut 10 0 20 0 11 1 21 0 0 LINE 8 Off 10 0 20 0 11 2 21 0 0 LINE 8 Frozen 10 0 20 0 11 3 21 0 "
      "0 LINE 8 Fold~Lines 10 0 20 0 11 4 21 0 0 LINE 8 Cut 62 3 10 0 20 0 11 5 21 0 "
      "0 LINE 8 CUT 420 1193046 10 0 20 0 11 6 21 0 0 LINE 8 Cut 60 1 10 0 20 0 11 7 21 0 "
      "0 LINE 8 Gr\\U+00F6\\U+00DFe 10 0 20 0 11 8 21 0",
      table);
  const auto lengths = [&text](const std::vector<std::string>& only, bool all = false) {
    drawing::Reading reading;
    reading.only = only;
    reading.all_shapes = all;
    std::vector<int> found;
    for (const cut::Subpath& line : cut_of(text, reading).path.subpaths) {
      found.push_back(static_cast<int>(drawing::length_of(line) + 0.5));
    }
    return found;
  };
  EXPECT_THAT(lengths({}), ElementsAre(1, 4, 5, 6, 8));
  EXPECT_THAT(lengths({}, true), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(lengths({"layer=Cut"}), ElementsAre(1, 5));
  EXPECT_THAT(lengths({"stroke=red"}), ElementsAre(1));
  EXPECT_THAT(lengths({"stroke=#0f0"}), ElementsAre(5));
  EXPECT_THAT(lengths({"stroke=#123456"}), ElementsAre(6));
  EXPECT_THAT(lengths({"stroke=blue", "layer=CUT"}), ElementsAre(4, 6));
  EXPECT_THAT(lengths({"layer=Fold Lines"}), ElementsAre(4));
  EXPECT_THAT(lengths({"layer=Gr\xc3\xb6\xc3\x9f"
                       "e"}),
              ElementsAre(8));
  EXPECT_THAT(cut_of(text).notes, ElementsAre("DXF: 1 x line type with dashes: not applied",
                                              "DXF: 3 x shape that is hidden or paints nothing: not cut"));
  drawing::Reading reading;
  reading.only = {"layer=Engrave"};
  const Result<Cut> unmatched = read_all(text, reading);
  ASSERT_FALSE(unmatched.ok());
  EXPECT_EQ(unmatched.error().reason, "SELECTOR_UNMATCHED");
  EXPECT_EQ(unmatched.error().field, "cut.curve.dxf.reading.only[0]");
  EXPECT_THAT(unmatched.error().message, HasSubstr("layer=Fold Lines"));
  EXPECT_EQ(indexed_colour(1), 0xff0000U);
  EXPECT_EQ(indexed_colour(30), 0xff7f00U);
  EXPECT_EQ(indexed_colour(250), 0x333333U);
}

TEST(DxfRead, LayersThatAreOffHideOnlyWhatLiesOnThem) {
  const std::string table = layers("0 LAYER 2 Off 62 -7 0 LAYER 2 Frozen 70 1 62 7 0 LAYER 2 On 62 7");
  const std::string block =
      " 0 SECTION 2 BLOCKS 0 BLOCK 2 B 10 0 20 0 0 LINE 8 0 10 0 20 0 11 1 21 0 0 LINE 8 On 10 0 20 0 11 2 21 0 "
      "0 LINE 8 Off 10 0 20 0 11 3 21 0 0 ENDBLK 0 BLOCK 2 C 10 0 20 0 0 INSERT 2 B 8 On 0 ENDBLK 0 ENDSEC";
  const auto lengths = [&](const std::string& entities) {
    std::vector<int> found;
    for (const cut::Subpath& line :
         cut_of(file(entities + " 0 LINE 8 0 10 0 20 0 11 9 21 0", table + block)).path.subpaths) {
      found.push_back(static_cast<int>(drawing::length_of(line) + 0.5));
    }
    return found;
  };
  EXPECT_THAT(lengths("0 INSERT 2 B 8 On"), ElementsAre(1, 2, 9));
  EXPECT_THAT(lengths("0 INSERT 2 B 8 Off"), ElementsAre(2, 9));
  EXPECT_THAT(lengths("0 INSERT 2 C 8 Off"), ElementsAre(1, 2, 9));
  EXPECT_THAT(lengths("0 INSERT 2 B 8 Frozen"), ElementsAre(9));
  EXPECT_THAT(lengths("0 INSERT 2 C 8 Frozen"), ElementsAre(9));
}

TEST(DxfRead, UnitsAndTrueSize) {
  const auto with_units = [](const std::string& header, const drawing::Reading& reading = {}) {
    return cut_of(groups(header + " 0 SECTION 2 ENTITIES 0 LINE 8 0 10 10 20 20 11 30 21 20 0 ENDSEC 0 EOF"), reading);
  };
  expect_extent(with_units(""), {0.01, 0.02, 0.03, 0.02});
  expect_extent(with_units("0 SECTION 2 HEADER 9 $INSUNITS 70 1 0 ENDSEC"), {0.254, 0.508, 0.762, 0.508});
  expect_extent(with_units("0 SECTION 2 HEADER 9 $INSUNITS 70 5 0 ENDSEC"), {0.1, 0.2, 0.3, 0.2});
  // A drawing without a unit may at least name its system.
  const Cut in_inches = with_units("0 SECTION 2 HEADER 9 $INSUNITS 70 0 9 $MEASUREMENT 70 0 0 ENDSEC");
  expect_extent(in_inches, {0.254, 0.508, 0.762, 0.508});
  EXPECT_THAT(in_inches.notes,
              ElementsAre("DXF: it names no unit ($INSUNITS): taken as inches, for which $MEASUREMENT stands"));
  EXPECT_THAT(with_units("0 SECTION 2 HEADER 9 $INSUNITS 70 99 0 ENDSEC").notes,
              ElementsAre("DXF: unit 99 ($INSUNITS) is unknown: taken as millimetres"));
  const Cut metric = with_units("0 SECTION 2 HEADER 9 $MEASUREMENT 70 1 0 ENDSEC");
  expect_extent(metric, {0.01, 0.02, 0.03, 0.02});
  EXPECT_THAT(metric.notes, ElementsAre(HasSubstr("taken as millimetres")));
  const Cut stated = with_units("0 SECTION 2 HEADER 9 $INSUNITS 70 4 9 $MEASUREMENT 70 0 0 ENDSEC");
  expect_extent(stated, {0.01, 0.02, 0.03, 0.02});
  EXPECT_THAT(stated.notes, IsEmpty());
  drawing::Reading reading;
  reading.unit = 1.0;
  EXPECT_THAT(with_units("0 SECTION 2 HEADER 9 $MEASUREMENT 70 0 0 ENDSEC", reading).notes, IsEmpty());
  expect_extent(with_units("0 SECTION 2 HEADER 9 $INSUNITS 70 1 0 ENDSEC", reading), {10, 20, 30, 20});
  // A drawing of CAD has no page: its origin lies at `at`.
  reading.true_size = true;
  reading.at = Vector2d(1, 2);
  expect_extent(with_units("", reading), {11, 22, 31, 22});
  reading = {};
  reading.fit_page = true;
  const Result<Cut> no_page = read_all(file("0 LINE 8 0 10 0 20 0 11 1 21 0"), reading);
  EXPECT_EQ(no_page.error().reason, "PAGE_MISSING");
}

TEST(DxfRead, ReportsWhatIsNotCut) {
  const std::string line = " 0 LINE 8 0 10 0 20 0 11 1 21 0";
  EXPECT_THAT(cut_of(file("0 TEXT 8 0 1 Hello 0 TEXT 8 0 1 you 0 HATCH 8 0 0 POINT 8 0 10 1 20 1" + line)).notes,
              ElementsAre("DXF: 1 x HATCH: not cut", "DXF: 1 x POINT: not cut", "DXF: 2 x TEXT: not cut"));
  EXPECT_THAT(cut_of(file("0 LINE 8 0 67 1 10 0 20 0 11 5 21 0" + line)).notes,
              ElementsAre("DXF: 1 x entity of a paper layout: not cut"));
  EXPECT_THAT(cut_of(file("0 CIRCLE 8 0 10 0 20 0 40 0 0 SPLINE 8 0 71 3 40 0 40 1 10 0 20 0 10 1 20 1" + line)).notes,
              ElementsAre("DXF: 1 x CIRCLE that has no length or is faulty: not cut",
                          "DXF: 1 x SPLINE that has no length or is faulty: not cut"));
  EXPECT_THAT(cut_of(file("0 VIEWPORT 8 0 0 ATTDEF 8 0" + line)).notes, IsEmpty());
}

TEST(DxfRead, LineEndsAndComments) {
  const std::string text = file("0 LINE 8 0 10 0 20 0 11 1 21 0");
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_extent(cut_of(crlf), {0, 0, 1, 0});
  std::string doubled;
  for (const char c : crlf) doubled += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_TRUE(is_dxf(doubled));
  expect_extent(cut_of(doubled), {0, 0, 1, 0});
  std::string cr = text;
  for (char& c : cr) c = c == '\n' ? '\r' : c;
  expect_extent(cut_of(cr), {0, 0, 1, 0});
  expect_extent(cut_of("999\nmade by hand\n" + text), {0, 0, 1, 0});
  expect_extent(cut_of("\xef\xbb\xbf" + text), {0, 0, 1, 0});
  expect_extent(cut_of("\n \r\n" + text), {0, 0, 1, 0});
  std::string wide = "\xff\xfe";
  for (const char c : text) wide += std::string(1, c) + '\0';
  EXPECT_TRUE(is_dxf(wide));
  expect_extent(cut_of(wide), {0, 0, 1, 0});
  expect_extent(cut_of(file("0 LINE 8 0 10 0 20 0 11 0.1D+01 21 0")), {0, 0, 1, 0});
  EXPECT_TRUE(is_dxf(crlf));
  EXPECT_TRUE(is_dxf("999\nmade by hand\n" + text));
  EXPECT_TRUE(is_dxf("  0\nSECTION"));
  EXPECT_FALSE(is_dxf("<svg/>"));
  EXPECT_FALSE(is_dxf(""));
  EXPECT_FALSE(is_dxf("0"));
}

TEST(DxfRead, Gzip) {
  const std::string packed = drawing::gzipped(file("0 LINE 8 0 10 0 20 0 11 1 21 0"));
  expect_extent(cut_of(packed), {0, 0, 1, 0});
  EXPECT_TRUE(is_dxf(packed));
  EXPECT_FALSE(is_dxf(drawing::gzipped("<svg/>")));
  EXPECT_THAT(read_all(drawing::gzipped(packed)).error().message, HasSubstr("compressed twice"));
  EXPECT_EQ(read_all(drawing::gzipped(std::string(kMaxFileBytes + 1, ' '))).error().reason, "DXF_TOO_LARGE");
  EXPECT_EQ(read_all("\x1f\x8bno gzip").error().reason, "DXF_MALFORMED");
}

TEST(DxfRead, RefusesWithReason) {
  const std::string line = "0 LINE 8 0 10 0 20 0 11 1 21 0";
  std::string blocks = "0 SECTION 2 BLOCKS 0 BLOCK 2 B0 10 0 20 0 " + line + " 0 ENDBLK";
  for (int i = 1; i < 8; ++i) {
    blocks += " 0 BLOCK 2 B" + std::to_string(i) + " 0 INSERT 2 B" + std::to_string(i - 1) + " 70 10 0 ENDBLK";
  }
  blocks += " 0 ENDSEC";
  struct Case {
    std::string text;
    std::string reason;
  };
  const std::vector<Case> cases{
      {"", "DXF_MALFORMED"},
      {"<svg/>", "DXF_MALFORMED"},
      {groups("0 SECTION 2 HEADER 0 ENDSEC 0 EOF"), "DXF_MALFORMED"},
      {file("0 LINE 8 0 10 zero 20 0"), "DXF_MALFORMED"},
      {file("0 LINE x 0"), "DXF_MALFORMED"},
      {"AutoCAD Binary DXF\r\n\x1a", "DXF_BINARY"},
      {"AC1027 and more", "DXF_BINARY"},
      {std::string(kMaxFileBytes + 1, ' '), "DXF_TOO_LARGE"},
      {file("0 TEXT 8 0"), "DXF_EMPTY"},
      {file("0 INSERT 2 B7", blocks), "DXF_TOO_COMPLEX"},
      {file("0 LINE 8 0 10 0 20 0 11 1e30 21 0"), "CURVE_OUT_OF_RANGE"},
  };
  for (const Case& item : cases) {
    const Result<Cut> done = read_all(item.text);
    ASSERT_FALSE(done.ok()) << item.text.substr(0, 200);
    EXPECT_EQ(done.error().reason, item.reason) << item.text.substr(0, 200);
    EXPECT_EQ(done.error().field, "cut.curve.dxf");
  }
  EXPECT_THAT(read_all(file("0 LINE 8 0 10 zero 20 0")).error().message, HasSubstr("line 24 of the drawing: 'zero'"));
  EXPECT_THAT(read_all(file(line + " 0 LWPOLYLINE 8 0 70 0 10 0 20 0 42 1e12 10 2 20 0")).error().message,
              HasSubstr("LWPOLYLINE at line 32 reaches beyond"));
  EXPECT_THAT(read_all("\n<svg/>").error().message, HasSubstr("the file is XML"));
  EXPECT_THAT(read_all(file("0 LINE 8 0 10 nan 20 0")).error().message, HasSubstr("line 24 of the drawing: 'nan'"));
  EXPECT_THAT(read_all(file("0 CIRCLE 8 0 40 inf")).error().message, HasSubstr("line 24 of the drawing: 'inf'"));
}

TEST(DxfRead, FilesThatEndTooEarlyAreRefused) {
  const std::string blocks = groups("0 SECTION 2 BLOCKS 0 BLOCK 2 B 10 0 20 0 " + line_to_one() + " 0 ENDBLK");
  const std::string entities = groups("0 SECTION 2 ENTITIES " + line_to_one() + " " + line_to_one());
  for (const std::string& text : {blocks, entities, entities + groups("0 EOF"), blocks + entities}) {
    const Result<Cut> done = read_all(text);
    ASSERT_FALSE(done.ok()) << text;
    EXPECT_EQ(done.error().reason, "DXF_MALFORMED");
    EXPECT_THAT(done.error().message, HasSubstr("not saved or copied whole"));
  }
  expect_extent(cut_of(entities + groups("0 ENDSEC")), {0, 0, 1e-3, 0});
}

TEST(DxfRead, SurvivesMutilatedFiles) {
  const std::string good = file(
      "0 INSERT 8 L 2 B 10 0 20 0 70 2 44 3 0 SPLINE 8 0 71 2 72 6 73 3 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 10 1 "
      "20 2 10 2 "
      "20 0 0 LWPOLYLINE 8 0 70 1 10 0 20 0 42 1 10 2 20 0 42 1 0 ARC 8 0 10 0 20 0 40 2 50 270 51 90",
      "0 SECTION 2 BLOCKS 0 BLOCK 2 B 10 1 20 1 0 ELLIPSE 8 0 10 1 20 1 11 0 21 3 40 0.5 0 ENDBLK 0 ENDSEC");
  ASSERT_TRUE(read_all(good).ok());
  SeededRandom random(5);
  int accepted = 0;
  for (int trial = 0; trial < 10'000; ++trial) {
    std::string text = good;
    for (std::uint64_t k = 0; k <= random.below(3) && !text.empty(); ++k) {
      const std::size_t at = random.below(text.size());
      const std::uint64_t how = random.below(3);
      if (how == 0) text[at] = static_cast<char>('-' + random.below(14));
      if (how == 1) text.erase(at, random.below(20));
      if (how == 2) text.insert(at, text.substr(random.below(text.size()), random.below(30)));
    }
    const Result<Cut> done = read_all(text);
    accepted += done.ok() ? 1 : 0;
    if (done.ok()) {
      EXPECT_TRUE(cut::validate(done->path).ok());
    }
  }
  EXPECT_GT(accepted, 1000);
}

}  // namespace
}  // namespace kerf::dxf
