// Documents: what of them becomes lines, where these lie, and what is reported or refused.

#include "server/service/svg/svg.h"

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/fit.h"
#include "server/service/svg/transform.h"
#include "tests/svg/drawn.h"

namespace kerf::svg {
namespace {

using Eigen::Vector2d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// The extent in pixels with y down: low x, low y, high x, high y.
void expect_extent(const Drawing& drawing, const Eigen::Vector4d& pixels) {
  const cut::Box box = cut::extent(drawing.path);
  const Eigen::Vector4d found(box.low.x(), -box.high.y(), box.high.x(), -box.low.y());
  EXPECT_LT((found / kPixel - pixels).cwiseAbs().maxCoeff(), 1e-9) << (found / kPixel).transpose();
}

void expect_extent(const std::string& content, const Eigen::Vector4d& pixels) {
  SCOPED_TRACE(content);
  expect_extent(drawn(document(content)), pixels);
}

// Points of the first subpath in pixels, y down.
std::vector<Vector2d> points(const Drawing& drawing) {
  const cut::Subpath& subpath = drawing.path.subpaths.at(0);
  const auto pixel = [](const Vector2d& at) { return Vector2d(at.x() / kPixel, -at.y() / kPixel); };
  std::vector<Vector2d> all{pixel(subpath.start)};
  for (const cut::Segment& segment : subpath.segments) {
    all.push_back(pixel(std::visit([](const auto& each) { return each.end; }, segment)));
  }
  return all;
}

TEST(SvgRead, StandsUprightInMetres) {
  const Drawing drawing = drawn(document(R"svg(<path d="M96 0L0 192"/>)svg"));
  EXPECT_NEAR(drawing.path.subpaths[0].start.x(), 0.0254, 1e-15);
  EXPECT_EQ(drawing.path.subpaths[0].start.y(), 0.0);
  EXPECT_NEAR(std::get<cut::LineTo>(drawing.path.subpaths[0].segments[0]).end.y(), -0.0508, 1e-15);
}

TEST(SvgRead, BasicShapes) {
  expect_extent(R"svg(<rect x="10" y="20" width="30" height="40"/>)svg", {10, 20, 40, 60});
  expect_extent(R"svg(<rect x="10" y="20" width="30" height="40" rx="5"/>)svg", {10, 20, 40, 60});
  expect_extent(R"svg(<circle cx="50" cy="40" r="10"/>)svg", {40, 30, 60, 50});
  expect_extent(R"svg(<ellipse cx="50" cy="40" rx="20" ry="10"/>)svg", {30, 30, 70, 50});
  expect_extent(R"svg(<line x1="1" y1="2" x2="3" y2="5"/>)svg", {1, 2, 3, 5});
  expect_extent(R"svg(<polyline points="1,2 3,4 5,0"/>)svg", {1, 0, 5, 4});
  expect_extent(R"svg(<polygon points="1 2 3,4,5-1"/>)svg", {1, -1, 5, 4});
  EXPECT_FALSE(drawn(document(R"svg(<polyline points="1,2 3,4 5,0"/>)svg")).path.subpaths[0].closed);
  EXPECT_TRUE(drawn(document(R"svg(<polygon points="1,2 3,4 5,0"/>)svg")).path.subpaths[0].closed);
  // Corners are quarters of ellipses; radii at most half the sides, one that is missing as the other.
  const cut::Subpath round =
      drawn(document(R"svg(<rect width="30" height="40" rx="50" ry="10"/>)svg")).path.subpaths.at(0);
  EXPECT_EQ(std::count_if(round.segments.begin(), round.segments.end(),
                          [](const auto& each) { return std::holds_alternative<cut::QuadraticTo>(each); }),
            4);
  EXPECT_NEAR(round.start.x() / kPixel, 15, 1e-12);
}

TEST(SvgRead, CirclesStayExactUnderAnyTransform) {
  // Twice as wide, turned by 30 degrees: an ellipse with semi-axes 20 and 10.
  const Drawing drawing = drawn(document(R"svg(<g transform="rotate(30) scale(2,1)"><circle r="10"/></g>)svg"));
  const double c = std::cos(std::acos(-1.0) / 6);
  const double s = 0.5;
  const double half_x = std::sqrt(400 * c * c + 100 * s * s);
  const double half_y = std::sqrt(400 * s * s + 100 * c * c);
  expect_extent(drawing, {-half_x, -half_y, half_x, half_y});
}

TEST(SvgRead, TransformsNestAndApplyFromTheRight) {
  const auto at = [](const std::string& transform) {
    return points(drawn(document("<g transform=\"" + transform + R"svg("><path d="M0 0L10 20"/></g>)svg")))[1];
  };
  EXPECT_LT((at("translate(5)") - Vector2d(15, 20)).norm(), 1e-12);
  EXPECT_LT((at("translate(5,-6)") - Vector2d(15, 14)).norm(), 1e-12);
  EXPECT_LT((at("scale(2)") - Vector2d(20, 40)).norm(), 1e-12);
  EXPECT_LT((at("scale(2 -1)") - Vector2d(20, -20)).norm(), 1e-12);
  EXPECT_LT((at("rotate(90)") - Vector2d(-20, 10)).norm(), 1e-12);
  EXPECT_LT((at("rotate(90, 10, 0)") - Vector2d(-10, 0)).norm(), 1e-12);
  EXPECT_LT((at("skewX(45)") - Vector2d(30, 20)).norm(), 1e-12);
  EXPECT_LT((at("skewY(45)") - Vector2d(10, 30)).norm(), 1e-12);
  EXPECT_LT((at("matrix(1 2 3 4 5 6)") - Vector2d(10 + 60 + 5, 20 + 80 + 6)).norm(), 1e-12);
  EXPECT_LT((at("translate(1,2), scale(3)") - Vector2d(31, 62)).norm(), 1e-12);
  EXPECT_LT((at("scale(3)translate(1,2)") - Vector2d(33, 66)).norm(), 1e-12);
  EXPECT_LT((points(drawn(document(R"svg(<g transform="scale(3)"><g transform="translate(1,2)"><path d="M0 0L10 20"
                                     transform="scale(2)"/></g></g>)svg")))[1] -
             Vector2d(63, 126))
                .norm(),
            1e-12);
}

TEST(SvgRead, ViewBoxesAndAspectRatios) {
  const std::string shape = R"svg(<rect width="10" height="10"/>)svg";
  const auto extent = [&](const std::string& attributes, const Eigen::Vector4d& pixels) {
    SCOPED_TRACE(attributes);
    expect_extent(drawn(document(shape, attributes)), pixels);
  };
  extent(R"svg(width="200" height="100" viewBox="0 0 10 10")svg", {50, 0, 150, 100});
  extent(R"svg(width="200" height="100" viewBox="0 0 10 10" preserveAspectRatio="xMinYMin")svg", {0, 0, 100, 100});
  extent(R"svg(width="200" height="100" viewBox="0 0 10 10" preserveAspectRatio="xMaxYMid meet")svg",
         {100, 0, 200, 100});
  extent(R"svg(width="200" height="100" viewBox="0 0 10 10" preserveAspectRatio="xMidYMax slice")svg",
         {0, -100, 200, 100});
  extent(R"svg(width="200" height="100" viewBox="0 0 10 10" preserveAspectRatio="none")svg", {0, 0, 200, 100});
  extent(R"svg(width="200" height="200" viewBox="-10,-10,20,20")svg", {100, 100, 200, 200});
  extent(R"svg(viewBox="0 0 10 10")svg", {0, 0, 10, 10});
  extent(R"svg(width="1in" height="1in" viewBox="0 0 10 10")svg", {0, 0, 96, 96});
  extent(R"svg(width="50%" height="100%" viewBox="0 0 10 10" preserveAspectRatio="none")svg", {0, 0, 5, 10});
}

TEST(SvgRead, UnitsAndPercentages) {
  expect_extent(R"svg(<rect width="1in" height="2.54cm"/>)svg", {0, 0, 96, 96});
  expect_extent(R"svg(<rect width="25.4mm" height="72pt"/>)svg", {0, 0, 96, 96});
  expect_extent(R"svg(<rect width="6pc" height="96px"/>)svg", {0, 0, 96, 96});
  expect_extent(R"svg(<rect x="10%" width="50%" height="25%"/>)svg", {10, 0, 60, 25});
  expect_extent(R"svg(<circle r="50%"/>)svg", {-50, -50, 50, 50});  // of sqrt((100^2 + 100^2) / 2)
  expect_extent(R"svg(<rect width="2em" height="1e1"/>)svg", {0, 0, 32, 10});
  expect_extent(R"svg(<rect width="1IN" height="25.4MM"/>)svg", {0, 0, 96, 96});
  expect_extent(R"svg(<rect width="2rem" height="101.6Q"/>)svg", {0, 0, 32, 96});
}

TEST(SvgRead, NestedViewportsUseAndSymbols) {
  expect_extent(
      R"svg(<svg x="10" y="20" width="40" height="40" viewBox="0 0 4 4"><rect width="4" height="2"/></svg>)svg",
      {10, 20, 50, 40});
  expect_extent(R"svg(<defs><rect id="r" width="5" height="6"/></defs><use xlink:href="#r" x="10" y="20"/>)svg",
                {10, 20, 15, 26});
  expect_extent(R"svg(<defs><g id="g" transform="scale(2)"><rect width="5" height="6"/></g></defs>
                   <use href="#g" transform="translate(1,1)" x="10"/>)svg",
                {11, 1, 21, 13});
  expect_extent(R"svg(<symbol id="s" viewBox="0 0 2 2"><rect width="2" height="2"/></symbol>
                   <use href="#s" x="10" y="10" width="20" height="20"/>)svg",
                {10, 10, 30, 30});
  EXPECT_EQ(drawn(document(R"svg(<rect id="r" width="5" height="6"/><use href="#r" x="9"/>)svg")).path.subpaths.size(),
            2U);
  // A percentage within refers to the inner viewport.
  expect_extent(R"svg(<svg width="40" height="20"><rect width="50%" height="50%"/></svg>)svg", {0, 0, 20, 10});
}

TEST(SvgRead, LeavesOutWhatIsHidden) {
  const std::string box = R"svg(<rect width="1" height="1"/>)svg";
  for (const char* hidden :
       {R"svg(<rect width="9" height="9" display="none"/>)svg",
        R"svg(<g display="none"><rect width="9" height="9"/></g>)svg",
        R"svg(<rect width="9" height="9" style="fill:red; display : none !important"/>)svg",
        R"svg(<g visibility="hidden"><rect width="9" height="9"/></g>)svg", R"svg(<rect width="0" height="9"/>)svg",
        R"svg(<circle r="-1"/>)svg", R"svg(<defs><rect width="9" height="9"/></defs>)svg",
        R"svg(<clipPath><rect width="9" height="9"/></clipPath>)svg",
        R"svg(<g transform="scale(0)"><circle r="9"/></g>)svg",
        R"svg(<svg width="0" height="9"><circle r="9"/></svg>)svg", R"svg(<sodipodi:namedview id="x"/>)svg",
        R"svg(<metadata><rdf:RDF><circle r="9"/></rdf:RDF></metadata>)svg"}) {
    const Drawing drawing = drawn(document(hidden + box));
    EXPECT_EQ(drawing.path.subpaths.size(), 1U) << hidden;
    const bool is_there = std::string(hidden).find("display") != std::string::npos ||
                          std::string(hidden).find("visibility") != std::string::npos;
    EXPECT_EQ(drawing.not_cut.size(), is_there ? 1U : 0U) << hidden;
  }
  expect_extent(
      R"svg(<g visibility="hidden"><rect width="9" height="9"/><rect width="3" height="3" visibility="visible"/></g>)svg",
      {0, 0, 3, 3});
  expect_extent(
      R"svg(<switch><foreignObject requiredExtensions="x"/><g><rect width="3" height="3"/></g><circle r="9"/></switch>)svg",
      {0, 0, 3, 3});
}

TEST(SvgRead, ReportsWhatIsNotCut) {
  const std::string box = R"svg(<rect width="1" height="1"/>)svg";
  const auto report = [&](const std::string& content) { return drawn(document(content + box)).not_cut; };
  EXPECT_THAT(report("<text>a</text><g><text>b<tspan>c</tspan></text></g>"),
              ElementsAre("SVG: 2 x text element: not cut"));
  EXPECT_THAT(report(R"svg(<image href="x.png"/>)svg"), ElementsAre("SVG: 1 x image element: not cut"));
  EXPECT_THAT(report("<script>alert(1)</script>"), ElementsAre("SVG: 1 x script element: not cut"));
  EXPECT_THAT(report("<style>@import 'more.css';</style><style type=\"text/less\">@a: 1;</style>"),
              ElementsAre("SVG: 1 x external style sheet: not applied", "SVG: 1 x style sheet: not applied"));
  EXPECT_THAT(report("<style> </style>"), IsEmpty());
  EXPECT_THAT(
      report(R"svg(<g clip-path="url(#c)"/><g style="mask:url(#m)"/>)svg"),
      ElementsAre("SVG: 1 x reference to a clip-path: not applied", "SVG: 1 x reference to a mask: not applied"));
  EXPECT_THAT(report(R"svg(<filter id="f"/><g filter="url(#f)"/><g filter="none"/>)svg"),
              ElementsAre("SVG: 1 x reference to a filter: not applied"));
  EXPECT_THAT(report(R"svg(<pattern id="p"><circle r="3"/></pattern><circle r="2" fill="url(#p)"/>)svg"),
              ElementsAre("SVG: 1 x reference to a pattern: not applied", HasSubstr("beyond its viewport")));
  EXPECT_THAT(report(R"svg(<use href="other.svg#x"/><use href="#nothing"/>)svg"),
              ElementsAre("SVG: 1 x external reference: not cut", "SVG: 1 x use of a missing element: not cut"));
  EXPECT_THAT(report("<hexagon/>"), ElementsAre("SVG: 1 x unknown element: not cut"));
  EXPECT_THAT(report(R"svg(<path d="M0 0L9 9Q1 1 2"/>)svg"),
              ElementsAre("SVG: 1 x path with an error in its data, cut up to it (the first at byte 14: a number is "
                          "missing after 'Q')"));
  EXPECT_THAT(report(R"svg(<path d="M0 0L9 9" transform="translate(x)"/>)svg"),
              ElementsAre("SVG: 1 x element with a transform that cannot be read: not cut"));
  EXPECT_THAT(report(R"svg(<path d="M0 0L9 9" style="transform:perspective(2px)"/>)svg"),
              ElementsAre("SVG: 1 x element with a transform that cannot be read: not cut"));
  EXPECT_THAT(report(R"svg(<path d="M0 0L101 9"/>)svg"),
              ElementsAre("SVG: it reaches beyond its viewport; nothing was clipped"));
}

TEST(SvgRead, PrefixedNamespaces) {
  const Drawing drawing =
      drawn(R"svg(<svg:svg xmlns:svg="http://www.w3.org/2000/svg" xmlns:x="other" width="9" height="9">
      <svg:g><svg:rect width="2" height="3"/></svg:g><x:rect width="9" height="9"/><rect width="9" height="9"/></svg:svg>)svg");
  EXPECT_EQ(drawing.path.subpaths.size(), 1U);
  expect_extent(drawing, {0, 0, 2, 3});
}

TEST(SvgRead, RefusesWithReason) {
  struct Case {
    std::string text;
    std::string reason;
  };
  std::string deep;
  for (int i = 0; i < 65; ++i) deep += "<g>";
  deep += R"svg(<circle r="1"/>)svg";
  for (int i = 0; i < 65; ++i) deep += "</g>";
  std::string many;
  for (int i = 0; i < 50'000; ++i) many += "<a/>";
  std::string segments = "<path d=\"M0 0";
  for (int i = 0; i < 10'001; ++i) segments += " 1 1";
  // Each level draws the one below ten times: 10^9 elements.
  std::string bomb = R"svg(<defs><g id="u0"><a/></g>)svg";
  for (int i = 1; i < 10; ++i) {
    bomb += "<g id=\"u" + std::to_string(i) + "\">";
    for (int k = 0; k < 10; ++k) bomb += "<use href=\"#u" + std::to_string(i - 1) + "\"/>";
    bomb += "</g>";
  }
  bomb += R"svg(</defs><use href="#u9"/>)svg";
  std::string fat = "<defs><path id=\"p\" d=\"" + std::string(100'000, ' ') + "\"/></defs>";
  for (int i = 0; i < 100; ++i) fat += R"svg(<use href="#p"/>)svg";
  const std::vector<Case> cases{
      {"", "SVG_MALFORMED"},
      {"no xml", "SVG_MALFORMED"},
      {"<svg><g></svg>", "SVG_MALFORMED"},
      {"<html><svg/></html>", "SVG_MALFORMED"},
      {std::string("\x1f\x8b\x08\x00", 4), "SVG_MALFORMED"},
      {document(""), "SVG_EMPTY"},
      {document("<text>only words</text>"), "SVG_EMPTY"},
      {document(R"svg(<path d="M1 1L1 1"/>)svg"), "CURVE_DEGENERATE"},
      {document(R"svg(<path d="M0 0L1e30 0"/>)svg"), "CURVE_OUT_OF_RANGE"},
      {document(R"svg(<g transform="scale(1e300)"><g transform="scale(1e300)"><path d="M0 0L1 1"/></g></g>)svg"),
       "CURVE_NOT_FINITE"},
      {std::string(kMaxTextBytes + 1, ' '), "SVG_TOO_LARGE"},
      {document(deep), "SVG_TOO_COMPLEX"},
      {document(many), "SVG_TOO_COMPLEX"},
      {document(bomb), "SVG_TOO_COMPLEX"},
      {document(fat), "SVG_TOO_COMPLEX"},
      {document(segments + "\"/>"), "CURVE_TOO_LONG"},
  };
  for (const Case& item : cases) {
    const Result<Drawing> drawing = read_all(item.text);
    ASSERT_FALSE(drawing.ok()) << item.text.substr(0, 200);
    EXPECT_EQ(drawing.error().reason, item.reason) << item.text.substr(0, 200);
    EXPECT_EQ(drawing.error().field, "cut.curve.svg");
    EXPECT_FALSE(drawing.error().message.empty());
  }
}

TEST(SvgRead, AcceptsTheLimitsThemselves) {
  std::string deep;
  for (int i = 0; i < 62; ++i) deep += "<g>";
  deep += R"svg(<circle r="1"/>)svg";
  for (int i = 0; i < 62; ++i) deep += "</g>";
  EXPECT_TRUE(read_all(document(deep)).ok());
  std::string segments = "<path d=\"M0 0";
  for (int i = 0; i < 10'000; ++i) segments += " 1 1";
  segments += "\"/>";
  const Drawing drawing = drawn(document(segments));
  EXPECT_EQ(drawing.path.subpaths.at(0).segments.size(), 10'000U);
  std::string padded = document(R"svg(<circle r="1"/>)svg");
  padded += std::string(kMaxTextBytes - padded.size(), ' ');
  EXPECT_TRUE(read_all(padded).ok());
}

TEST(SvgRead, EntitiesOfTheDocumentTypeAreReplaced) {
  const std::string type = R"svg(<?xml version="1.0"?><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "svg11.dtd" [
      <!ENTITY st0 "fill:none;stroke:#F00;"><!ENTITY hidden 'display:none'><!ENTITY p "M0 0L5 0&q;"><!ENTITY q "L5 9">]>)svg";
  const Drawing drawing = drawn(type + R"svg(<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9">
      <path style="&st0;" d="&p;"/><rect style="&hidden;" width="20" height="20"/></svg>)svg");
  expect_extent(drawing, {0, 0, 5, 9});
  EXPECT_THAT(drawing.not_cut, ElementsAre("SVG: 1 x shape that is hidden or paints nothing: not cut"));
  for (const std::string leaf : {"aaaaaaaaaa", ""}) {
    std::string bomb = "<!DOCTYPE svg [<!ENTITY a0 \"" + leaf + "\">";
    for (int i = 1; i < 9; ++i) {
      bomb += "<!ENTITY a" + std::to_string(i) + " \"";
      for (int k = 0; k < 100; ++k) bomb += "&a" + std::to_string(i - 1) + ";";
      bomb += "\">";
    }
    EXPECT_EQ(read_all(bomb + "]><svg><path d=\"&a7;\"/></svg>").error().reason, "SVG_TOO_LARGE");
  }
  EXPECT_EQ(read_all("<!DOCTYPE svg [<!ENTITY a \"&a;\">]><svg><path d=\"&a;\"/></svg>").error().reason, "SVG_EMPTY");
}

TEST(SvgRead, LengthsThatCannotBeReadAreTold) {
  const Drawing drawing = drawn(document(R"svg(<rect width="10vw" height="5"/><circle cx="1e400" r="2"/>
      <rect rx="auto" x="" width="9" height="9"/>)svg"));
  EXPECT_THAT(drawing.not_cut,
              ::testing::Contains("SVG: 2 x length that cannot be read (the first: width=\"10vw\"): not applied"));
  EXPECT_THAT(drawn(document("<path d=\"M0 0L5 5\"/>", R"svg(width="400,5mm" height="3")svg")).not_cut,
              ElementsAre("SVG: 1 x length that cannot be read (the first: width=\"400,5mm\"): not applied"));
}

TEST(SvgRead, FaultsNameTheLine) {
  EXPECT_THAT(read_all("<svg>\n<g>\n</svg>").error().message, HasSubstr("line 3: not XML"));
  // Lines of embedded pictures count.
  const std::string picture = "<svg><image href=\"data:image/png;base64,AA\nAA\nAA\"/>\n<path d=\"M0 0";
  EXPECT_THAT(read_all(picture).error().message, HasSubstr("line 4: not XML"));
}

TEST(SvgRead, EncodingsThatAreNotKnownAreTold) {
  const std::string text =
      "<?xml version=\"1.0\" encoding=\"windows-1251\"?><svg><path id=\"\xd1\" d=\"M0 0L5 5\"/></svg>";
  EXPECT_THAT(drawn(text).not_cut,
              ElementsAre("SVG: 1 x encoding windows-1251 (names are taken as ISO-8859-1): not applied"));
}

TEST(SvgRead, NamesOfSvgMayHaveAPrefixOrNone) {
  expect_extent(drawn(R"svg(<x:svg xmlns:x="http://www.w3.org/2000/svg" xmlns="http://www.w3.org/2000/svg"
      xmlns:l="http://www.w3.org/1999/xlink" width="9" height="9"><defs><path id="p" d="M0 0L5 6"/></defs><x:g><use
      l:href="#p"/></x:g></x:svg>)svg"),
                {0, 0, 5, 6});
}

TEST(SvgRead, ViewportsWithinTellOfOutlinesBeyondThem) {
  const std::string inner = R"svg(<svg x="10" y="10" width="20" height="20")svg";
  const auto notes = [&](const std::string& attributes, const std::string& side) {
    return drawn(document(inner + attributes + "><rect width=\"" + side + "\" height=\"5\"/></svg>")).not_cut;
  };
  EXPECT_THAT(notes("", "20"), IsEmpty());
  EXPECT_THAT(notes("", "21"), ElementsAre(HasSubstr("beyond its viewport")));
  EXPECT_THAT(notes(" overflow=\"visible\"", "21"), IsEmpty());
  EXPECT_THAT(notes(" viewBox=\"0 0 40 40\"", "40"), IsEmpty());
}

TEST(SvgRead, ReadsNoOtherFilesAndFollowsNoCycle) {
  const std::string bomb = R"svg(<?xml version="1.0"?><!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">
      <!ENTITY x SYSTEM "file:///etc/passwd">]><svg width="9" height="9"><title>&b;&x;</title><path id="&x;" d="M0 0L5 5&b;"/></svg>)svg";
  const Drawing drawing = drawn(bomb);
  EXPECT_EQ(drawing.path.subpaths.size(), 1U);
  EXPECT_THAT(drawing.not_cut, ElementsAre(HasSubstr("path with an error")));
  const Drawing cycle =
      drawn(document(R"svg(<g id="a"><use href="#b"/></g><g id="b"><use href="#a"/><circle r="1"/></g>)svg"));
  EXPECT_EQ(cycle.path.subpaths.size(), 2U);
  EXPECT_THAT(cycle.not_cut, ::testing::Contains(HasSubstr("use of an element that contains it")));
}

TEST(SvgRead, SurvivesMutilatedDocuments) {
  const std::string good =
      document(R"svg(<defs><symbol id="s" viewBox="0 0 2 2"><rect rx=".3" width="2" height="2"/></symbol></defs>
      <g transform="matrix(1 2 3 4 5 6) rotate(3)" style="display:inline;fill:url(#p)"><use xlink:href="#s" width="5mm"/>
      <path d="M1.5.5C1 2 3 4-5-6s.1.2.3.4a5 5 0 1017 3q1 1 2 2t3 3hv1z"/><polygon points="1,2 3,4 5"/></g><text>x</text>)svg",
               R"svg(viewBox="0 0 9 9" width="10cm" preserveAspectRatio="xMaxYMin slice")svg");
  ASSERT_TRUE(read_all(good).ok());
  SeededRandom random(17);
  int accepted = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string text = good;
    for (std::uint64_t k = 0; k <= random.below(4); ++k) {
      if (text.empty()) break;
      const std::size_t at = random.below(text.size());
      switch (random.below(4)) {
        case 0:
          text[at] = static_cast<char>(random.below(256));
          break;
        case 1:
          text.erase(at, random.below(20));
          break;
        case 2:
          text.insert(at, text.substr(random.below(text.size()), random.below(30)));
          break;
        default:
          text.resize(at + 1);
          break;
      }
    }
    const Result<Drawing> drawing = read_all(text);
    if (drawing.ok()) {
      ++accepted;
      EXPECT_TRUE(cut::validate(drawing->path).ok());
    } else {
      EXPECT_FALSE(drawing.error().reason.empty());
    }
  }
  EXPECT_GT(accepted, 1000);
}

}  // namespace
}  // namespace kerf::svg
