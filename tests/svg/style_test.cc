// Style sheets, paint and dashes: which shapes of a drawing are cut, and how.

#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/service/drawing/arc_length.h"
#include "server/service/svg/css.h"
#include "tests/svg/drawn.h"

namespace kerf::svg {
namespace {

using ::testing::HasSubstr;

// Returns the sides, in pixels, of the squares that are cut, in the order of the drawing.
std::vector<int> sides(const std::string& content, const drawing::Reading& reading = {}) {
  std::vector<int> found;
  const Result<Drawing> drawing = read_all(document(content), reading);
  if (!drawing.ok()) return found;
  for (const cut::Subpath& line : drawing->path.subpaths) {
    found.push_back(static_cast<int>(drawing::length_of(line) / (4.0 * kPixel) + 0.5));
  }
  return found;
}

// Squares with sides 1 to 4 and names of all kinds.
const std::string kSquares =
    R"svg(<g id="g" class="outer"><rect id="a" class="h x" width="1" height="1"/><g>
          <rect id="b" class="k" width="2" height="2" data-kind="hole big"/></g></g>
          <rect id="c" class="h" width="3" height="3"/><svg:rect/><circle class="dot" r="0"/>
          <rect id="d" width="4" height="4" stroke="red"/>)svg";

struct Sheet {
  const char* css;
  std::vector<int> cut;
};

TEST(SvgStyle, SelectorsChoose) {
  const std::vector<Sheet> sheets{
      {".h{display:none}", {2, 4}},
      {"#b{display:none}", {1, 3, 4}},
      {"rect{display:none}", {}},
      {"*{display:none}", {}},
      {"rect.h{display:none}", {2, 4}},
      {".h.x{display:none}", {2, 3, 4}},
      {"g .h{display:none}", {2, 3, 4}},
      {"g > .k{display:none}", {1, 3, 4}},
      {"#g > .k{display:none}", {1, 2, 3, 4}},
      {"#g .k, #d{visibility:hidden}", {1, 3}},
      {"g + rect{display:none}", {1, 2, 4}},
      {"g ~ rect{display:none}", {1, 2}},
      {"[data-kind]{display:none}", {1, 3, 4}},
      {"[data-kind~='hole']{display:none}", {1, 3, 4}},
      {"rect[id=c]{display:none}", {1, 2, 4}},
      {"[data-kind^=\"ho\"]{display:none}", {1, 3, 4}},
      {"[data-kind*=e\\ b]{display:none}", {1, 3, 4}},
      {"rect:not(.h){display:none}", {1, 3}},
      {":is(.k, #c){display:none}", {1, 4}},
      {"rect:first-child{display:none}", {3, 4}},
      {"rect:last-child{display:none}", {1, 3}},
      {"svg > :nth-child(3){display:none}", {1, 2, 4}},
      {"svg > rect:nth-of-type(2n+1){display:none}", {1, 2}},
      {"rect:hover{display:none}", {1, 2, 3, 4}},
      {"rect::before{display:none}", {1, 2, 3, 4}},
      {":root .h{display:none}", {2, 4}},
      {"#\\61 {display:none}", {2, 3, 4}},
      {"svg|rect.k{display:none}", {1, 3, 4}},
      {"/* .k */ .h /* x */ { /* y */ DISPLAY : NONE }", {2, 4}},
      {"<!-- .h{display:none} -->", {1, 2, 3, 4}},  // A comment of XML.
      {"<![CDATA[ <!-- .h{display:none} --> ]]>", {2, 4}},
      {".outer{display:none}", {3, 4}},
      {"g g{opacity:0}", {1, 3, 4}},
      {".h{visibility:collapse}", {2, 4}},
      {".outer{visibility:hidden} .k{visibility:visible}", {2, 3, 4}},
      {"rect{fill:none}", {4}},
      {"rect{fill:none} #a{stroke:#000}", {1, 4}},
      {"rect{fill:none;stroke-width:0}", {}},
      {"rect{fill:none} #d{stroke-opacity:0%}", {}},
      {"#d{fill-opacity:0;stroke:transparent}", {1, 2, 3}},
      {".h{fill:rgba(1,2,3,0)}", {2, 4}},
      // A malformed rule or declaration does not spoil the next one.
      {"rect..h{display:none} .k{display:none}", {1, 3, 4}},
      {".h{display;} .k{colour:;display:none}", {1, 3, 4}},
      {".h{display:none", {2, 4}},
  };
  for (const Sheet& sheet : sheets) {
    EXPECT_EQ(sides("<style>" + std::string(sheet.css) + "</style>" + kSquares), sheet.cut) << sheet.css;
  }
}

TEST(SvgStyle, TheCascadeChooses) {
  const auto shown = [](const std::string& css, const std::string& attributes) {
    return !sides("<style>" + css + "</style><rect " + attributes + R"svg( width="1" height="1"/>)svg").empty();
  };
  EXPECT_TRUE(shown("rect{display:inline}", R"svg(display="none")svg"));  // A sheet beats an attribute.
  EXPECT_FALSE(shown("rect{display:inline}", R"svg(style="display:none")svg"));
  EXPECT_TRUE(shown("rect{display:inline!important}", R"svg(style="display:none")svg"));
  EXPECT_FALSE(shown("rect{display:inline!important}", R"svg(style="display:none ! IMPORTANT")svg"));
  EXPECT_FALSE(shown("#i{display:none} .c{display:inline} rect{display:inline}", R"svg(id="i" class="c")svg"));
  EXPECT_FALSE(shown(".c{display:none} rect{display:inline}", R"svg(class="c")svg"));
  EXPECT_TRUE(shown(".c{display:none} .d{display:inline}", R"svg(class="d c")svg"));  // The later rule.
  EXPECT_TRUE(shown(":where(#i){display:none} rect{display:inline}", R"svg(id="i")svg"));
  EXPECT_FALSE(shown("rect:not(#x){display:none} .c.c{display:inline}", R"svg(class="c")svg"));
}

TEST(SvgStyle, SheetsStandAnywhere) {
  const std::string circle = R"svg(<rect class="h" width="1" height="1"/>)svg";
  const std::string rule = ".h{display:none}";
  for (const std::string& sheet :
       {"<style>" + rule + "</style>", "<defs><style>" + rule + "</style></defs>",
        "<style type=\"text/css\"><![CDATA[" + rule + "]]></style>", "<g><style>" + rule + "</style></g>",
        "<style media=\"screen\">" + rule + "</style>", "<style>@media screen, print{" + rule + "}</style>",
        "<style>@media not print{" + rule + "}</style>", "<style>@charset \"utf-8\";" + rule + "</style>",
        "<style>@font-face{font-family:a;src:url(x)}" + rule + "</style>"}) {
    EXPECT_TRUE(sides(sheet + circle).empty()) << sheet;
    EXPECT_TRUE(sides(circle + sheet).empty()) << sheet;
  }
  for (const std::string& sheet : std::vector<std::string>{
           "<style media=\"print\">" + rule + "</style>", "<style>@media print{" + rule + "}</style>",
           "<style>@media (prefers-color-scheme: dark){" + rule + "}</style>",
           "<style type=\"text/less\">" + rule + "</style>", "<style>@keyframes a{from{}}</style>"}) {
    EXPECT_EQ(sides(sheet + circle).size(), 1U) << sheet;
  }
}

TEST(SvgStyle, WhatPaintsNothingIsNotCutAndDoesNotDecideTheExtent) {
  const std::string frame = R"svg(<path d="M0 0h24v24H0z" fill="none"/>)svg";
  const std::string inside = R"svg(<rect width="6" height="6"/>)svg";
  EXPECT_EQ(sides(frame + inside), std::vector<int>({6}));
  const std::vector<std::string> notes = drawn(document(frame + inside)).not_cut;
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0], "SVG: 1 x shape that is hidden or paints nothing: not cut");
  drawing::Reading all;
  all.all_shapes = true;
  EXPECT_EQ(sides(frame + inside, all), std::vector<int>({24, 6}));
  EXPECT_EQ(sides(R"svg(<g display="none"><rect width="2" height="2"/></g>)svg" + inside, all),
            std::vector<int>({2, 6}));
  const Result<Drawing> nothing = read_all(document(frame));
  ASSERT_FALSE(nothing.ok());
  EXPECT_EQ(nothing.error().reason, "SVG_EMPTY");
  EXPECT_THAT(nothing.error().message, HasSubstr("all_shapes"));
  for (const char* seen : {R"svg(fill="none" stroke="black")svg", R"svg(fill="url(#g)")svg", "",
                           R"svg(fill="currentColor")svg", R"svg(fill="none" style="stroke:hsl(120, 50%, 50%)")svg",
                           R"svg(fill="no colour")svg", R"svg(fill="none" stroke="#0f0" stroke-width="0.1mm")svg"}) {
    EXPECT_EQ(sides("<rect width=\"1\" height=\"1\" " + std::string(seen) + "/>").size(), 1U) << seen;
  }
  for (const char* unseen : {R"svg(fill="none" stroke="black" stroke-width="0")svg", R"svg(opacity="0")svg",
                             R"svg(fill-opacity="0")svg", R"svg(fill="#0000")svg", R"svg(fill="transparent")svg",
                             R"svg(fill="currentColor" color="#fff0")svg", R"svg(visibility="hidden")svg"}) {
    EXPECT_TRUE(sides("<rect width=\"1\" height=\"1\" " + std::string(unseen) + "/>").empty()) << unseen;
  }
  // Properties of a group are inherited; opacity takes all of a group with it.
  EXPECT_TRUE(sides(R"svg(<g fill="none"><rect width="1" height="1"/></g>)svg").empty());
  EXPECT_TRUE(sides(R"svg(<g opacity="0"><rect width="1" height="1" opacity="1"/></g>)svg").empty());
  EXPECT_EQ(sides(R"svg(<g fill="none"><rect width="1" height="1" fill="red"/></g>)svg").size(), 1U);
  EXPECT_EQ(
      sides(R"svg(<defs><rect id="r" width="1" height="1"/></defs><use href="#r" fill="none"/><use href="#r"/>)svg")
          .size(),
      1U);
}

// Returns the dashes of a horizontal line as starts and ends in pixels.
std::vector<double> dashes(const std::string& content,
                           const std::string& attributes = R"svg(width="100" height="100")svg") {
  std::vector<double> found;
  for (const cut::Subpath& line : drawn(document(content, attributes)).path.subpaths) {
    found.push_back(line.start.x() / kPixel);
    found.push_back(drawing::end_of(line.segments.back()).x() / kPixel);
  }
  return found;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-9) << i;
}

TEST(SvgStyle, DashedStrokesAreCutDashed) {
  const auto line = [](const std::string& attributes) { return R"svg(<line x2="40" )svg" + attributes + "/>"; };
  const std::vector<double> ten_five{0, 10, 15, 25, 30, 40};
  expect_near(dashes(line(R"svg(stroke-dasharray="10,5")svg")), ten_five);
  expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray="10 5")svg")), ten_five);
  expect_near(dashes(line(R"svg(stroke="red" style="stroke-dasharray: 10px , 5px")svg")), ten_five);
  expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray="10%,5%")svg")), ten_five);
  expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray="10,5" stroke-dashoffset="-2")svg")),
              {2, 12, 17, 27, 32, 40});
  expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray="10,5" stroke-dashoffset="12")svg")),
              {3, 13, 18, 28, 33, 40});
  expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray="8")svg")), {0, 8, 16, 24, 32, 40});
  expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray="10 5 3")svg")), {0, 10, 15, 18, 28, 33, 36, 40});
  expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray="1,.5" pathLength="4")svg")), ten_five);
  expect_near(dashes(R"svg(<g stroke="red" stroke-dasharray="5 2.5" transform="scale(2)"><line x2="20"/></g>)svg"),
              ten_five);
  expect_near(dashes(R"svg(<style>.p{stroke:red;stroke-dasharray:10,5}</style><line class="p" x2="40"/>)svg"),
              ten_five);
  expect_near(dashes(R"svg(<g transform="scale(2)"><line x2="20" stroke="red" stroke-dasharray="10 5"
                          vector-effect="non-scaling-stroke"/></g>)svg"),
              ten_five);
  for (const char* solid : {"none", "0", "0 0", "-1 2", "10 x", ""}) {
    expect_near(dashes(line(R"svg(stroke="red" stroke-dasharray=")svg" + std::string(solid) + "\"")), {0, 40});
  }
  // The outline of a fill has no dashes.
  EXPECT_EQ(
      drawn(document(R"svg(<rect width="9" height="9" stroke="none" stroke-dasharray="1"/>)svg")).path.subpaths.size(),
      1U);
  // Dashes of the cut replace those of the drawing.
  drawing::Reading solid;
  solid.dashes = false;
  EXPECT_EQ(drawn(document(line(R"svg(stroke-dasharray="10,5")svg")), solid).path.subpaths.size(), 1U);
}

TEST(SvgStyle, DashesFollowCurvesAndCorners) {
  // A circle of 100 units of length, by its pathLength: ten dashes of 6.
  const Drawing circle =
      drawn(document(R"svg(<circle cx="50" cy="50" r="30" stroke="red" pathLength="100" stroke-dasharray="6 4"/>)svg"));
  ASSERT_EQ(circle.path.subpaths.size(), 10U);
  for (const cut::Subpath& dash : circle.path.subpaths) {
    EXPECT_NEAR(drawing::length_of(dash) / kPixel, 0.06 * 2.0 * 3.14159265358979 * 30.0, 1e-6);
    const Eigen::Vector2d middle(50 * kPixel, -50 * kPixel);
    EXPECT_NEAR((dash.start - middle).norm() / kPixel, 30.0, 1e-9);
  }
  // The second dash of a square runs around its corner.
  const Drawing square = drawn(document(R"svg(<rect width="10" height="10" stroke="red" stroke-dasharray="6 2"/>)svg"));
  ASSERT_EQ(square.path.subpaths.size(), 5U);
  EXPECT_EQ(square.path.subpaths[1].segments.size(), 4U);  // Two sides, and a mark at each end.
  EXPECT_FALSE(square.path.subpaths[1].closed);
  double total = 0.0;
  for (const cut::Subpath& dash : square.path.subpaths) total += drawing::length_of(dash);
  EXPECT_NEAR(total / kPixel, 30.0, 1e-9);
  // Lengths within a cubic are right to a millionth.
  const Drawing cubic =
      drawn(document(R"svg(<path d="M0 0C90 0 0 90 90 90" stroke="red" fill="none" stroke-dasharray="7 3"/>)svg"));
  for (std::size_t i = 0; i + 1 < cubic.path.subpaths.size(); ++i) {
    EXPECT_NEAR(drawing::length_of(cubic.path.subpaths[i]) / kPixel, 7.0, 1e-5);
  }
}

TEST(SvgStyle, SizesAndPlacesMayBeStyles) {
  const auto expect_box = [](const std::string& content, double width, double height) {
    const cut::Box box = cut::extent(drawn(document(content)).path);
    EXPECT_NEAR((box.high.x() - box.low.x()) / kPixel, width, 1e-9) << content;
    EXPECT_NEAR((box.high.y() - box.low.y()) / kPixel, height, 1e-9) << content;
  };
  expect_box("<style>circle{r:20px}</style><circle r=\"1\" cx=\"50\"/>", 40, 40);
  expect_box("<style>rect{width:30px;height:20px;rx:2px}</style><rect x=\"10\"/>", 30, 20);
  expect_box("<rect width=\"10\" height=\"20\" style=\"rotate:90deg; translate: 30px 5px; scale:2\"/>", 40, 20);
  expect_box("<rect width=\"10\" height=\"20\" style=\"transform:translate(1cm) scale(2)\"/>", 20, 40);
  EXPECT_THAT(
      drawn(document("<rect style=\"fill:var(--c)\" width=\"5\" height=\"5\"/>")).not_cut,
      ::testing::ElementsAre("SVG: 1 x reference to a variable of a style sheet that is not there: not applied"));
}

TEST(SvgStyle, BoundsOnWork) {
  // Selectors that have to be compared with every element, many times over.
  std::string css;
  for (int i = 0; i < 2'000; ++i) css += "g g g * ~ *:not(.q" + std::to_string(i) + "){fill:red}";
  std::string deep = "<g><g><g><g>";
  for (int i = 0; i < 2'000; ++i) deep += R"svg(<rect width="1" height="1"/>)svg";
  const Result<Drawing> slow = read_all(document("<style>" + css + "</style>" + deep + "</g></g></g></g>"));
  ASSERT_FALSE(slow.ok());
  EXPECT_EQ(slow.error().reason, "SVG_TOO_COMPLEX");
  std::string many;
  for (int i = 0; i < 20'001; ++i) many += "a,";
  EXPECT_EQ(read_all(document("<style>" + many + "b{fill:red}</style>")).error().reason, "SVG_TOO_COMPLEX");
  // Short dashes on a long line.
  const Result<Drawing> dust = read_all(document(R"svg(<path d="M0 0H1e4" stroke="red" stroke-dasharray="1e-9"/>)svg"));
  ASSERT_FALSE(dust.ok());
  const Result<Drawing> long_one =
      read_all(document(R"svg(<path d="M0 0H1e4" stroke="red" stroke-dasharray="1"/>)svg"));
  EXPECT_EQ(long_one.error().reason, "CURVE_TOO_LONG");
}

TEST(SvgStyle, MediaQueries) {
  for (const char* yes :
       {"", "all", "screen", "print, screen", "only screen", "not print", "(prefers-color-scheme: light)"}) {
    EXPECT_TRUE(applies_to_screen(yes)) << yes;
  }
  for (const char* no :
       {"print", "not screen", "screen and (min-width: 1px)", "speech", "(prefers-color-scheme:dark)"}) {
    EXPECT_FALSE(applies_to_screen(no)) << no;
  }
}

}  // namespace
}  // namespace kerf::svg
