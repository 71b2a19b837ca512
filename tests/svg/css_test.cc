// Style sheets of drawings: variables, nested rules, paths as properties, and what is not understood.

#include "server/service/svg/css.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/cut/fit.h"
#include "server/service/svg/css_variables.h"
#include "tests/svg/drawn.h"

namespace kerf::svg {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Squares in groups, with sides 1 to 3.
const std::string kGroups = R"svg(<g class="a"><rect class="x" width="1" height="1"/><g class="b">
    <rect class="x y" width="2" height="2"/></g></g><rect class="x" width="3" height="3"/>)svg";

// Returns the widths, in pixels, of what is cut.
std::vector<int> widths(const std::string& content, const std::vector<std::string>& only = {}) {
  drawing::Reading reading;
  reading.only = only;
  std::vector<int> found;
  const Result<Drawing> drawing = read_all(document(content), reading);
  if (!drawing.ok()) return found;
  for (const cut::Subpath& line : drawing->path.subpaths) {
    const cut::Box box = cut::extent(cut::Curve(cut::Path{{line}}));
    found.push_back(static_cast<int>(std::lround((box.high.x() - box.low.x()) / kPixel)));
  }
  return found;
}
std::vector<int> styled(const std::string& css) {
  return widths("<style>" + css + "</style>" + kGroups);
}
std::vector<std::string> notes_of(const std::string& content) {
  return drawn(document(content)).not_cut;
}

TEST(SvgCss, VariablesStandForTheirValues) {
  EXPECT_THAT(styled(":root{--hide:none} .y{display:var(--hide)}"), ElementsAre(1, 3));
  EXPECT_THAT(styled(".a{--hide:none} .x{display:var(--hide,inline)}"), ElementsAre(3));
  EXPECT_THAT(styled(".a{--hide:none} .b{--hide:inline} .x{display:var( --hide , inline )}"), ElementsAre(2, 3));
  EXPECT_THAT(styled(".x{--w:var(--v);width:var(--w)} :root{--v:7px}"), ElementsAre(7, 7, 7));
  EXPECT_THAT(styled(".x{width:VAR(--none,var(--nor,9px))}"), ElementsAre(9, 9, 9));
  // Names have a case, and the cascade decides about variables, too.
  EXPECT_THAT(styled(":root{--W:9px;--w:8px} .x{width:var(--w)}"), ElementsAre(8, 8, 8));
  EXPECT_THAT(styled(".x{--w:5px!important;width:var(--w)} .y{--w:6px}"), ElementsAre(5, 5, 5));
  const std::string red =
      "<style>:root{--c:#f00}</style><rect width=\"4\" height=\"4\" fill=\"none\" stroke=\"var(--c)\"/>"
      "<rect width=\"5\" height=\"5\" style=\"--c:blue;stroke:var(--c)\"/>";
  EXPECT_THAT(widths(red, {"stroke=red"}), ElementsAre(4));
  EXPECT_THAT(widths(red, {"stroke=blue"}), ElementsAre(5));
  EXPECT_THAT(notes_of(red), IsEmpty());
}

TEST(SvgCss, VariablesWithoutAValueAreNamed) {
  for (const std::string css :
       {"", ":root{--c:initial}", ":root{--c:var(--d);--d:var(--c)}", ":root{--c:var(--c)}", "rect{--b:red}"}) {
    EXPECT_THAT(notes_of("<style>" + css + "</style><rect style=\"fill:var(--c)\" width=\"5\" height=\"5\"/>"),
                ElementsAre("SVG: 1 x reference to a variable of a style sheet that is not there: not applied"))
        << css;
  }
}

TEST(SvgCss, VariablesCannotGrowWithoutBound) {
  CustomProperties own{{"--a0", "x"}};
  for (int i = 1; i < 15; ++i) {
    const std::string before = "var(--a" + std::to_string(i - 1) + ")";
    own["--a" + std::to_string(i)] = before + before + before + before;
  }
  std::size_t steps = 0;
  const auto variables = variables_within(nullptr, own, steps);
  EXPECT_EQ(*variables->find("--a2"), std::string(16, 'x'));
  EXPECT_EQ(variables->find("--a14"), nullptr);
  EXPECT_LT(steps, 200'000U);
  std::string value = "1 var(--a1) not-var(--a1)";
  EXPECT_TRUE(replace_variables(value, variables.get(), steps));
  EXPECT_EQ(value, "1 xxxx not-var(--a1)");
  EXPECT_FALSE(replace_variables(value = "var(--a14)", variables.get(), steps));
  EXPECT_EQ(value, "");
}

TEST(SvgCss, RulesMayBeNested) {
  EXPECT_THAT(styled(".a{.x{display:none}}"), ElementsAre(3));
  EXPECT_THAT(styled(".a{& > .x{display:none}}"), ElementsAre(2, 3));
  EXPECT_THAT(styled(".a{> .x{display:none}}"), ElementsAre(2, 3));
  EXPECT_THAT(styled(".x{&.y{display:none}}"), ElementsAre(1, 3));
  EXPECT_THAT(styled(".x{.b &{display:none}}"), ElementsAre(1, 3));
  EXPECT_THAT(styled(".a{.b{.x{display:none}}}"), ElementsAre(1, 3));
  EXPECT_THAT(styled(".b,.c{.x,.z{display:none}}"), ElementsAre(1, 3));
  EXPECT_THAT(styled(".x{width:4px;.y{}.y&{width:5px}height:1px;&:hover{width:9px}}"), ElementsAre(4, 5, 4));
  EXPECT_THAT(styled(".x{@media screen{width:6px}@media print{width:7px}}"), ElementsAre(6, 6, 6));
  EXPECT_THAT(styled(".x{@media screen{.y&{width:6px}}}"), ElementsAre(1, 6, 3));
  // Declarations after a nested rule come later, and count as such.
  EXPECT_THAT(styled(".y{&{width:6px}width:7px}"), ElementsAre(1, 7, 3));
  std::string deep;
  for (int i = 0; i < 15; ++i) deep += ".a,.b,.c,.d,.e,.f,.g,.h,.i,.j{";
  EXPECT_EQ(read_all(document("<style>" + deep + "fill:red" + std::string(15, '}') + "</style>")).error().reason,
            "SVG_TOO_COMPLEX");
}

TEST(SvgCss, LayersComeBeforeRulesWithoutOne) {
  EXPECT_THAT(styled(".x{width:5px}@layer a{.x{width:6px}}"), ElementsAre(5, 5, 5));
  EXPECT_THAT(styled("@layer a,b;@layer b{.x{width:6px}}@layer a{.x{width:7px}}"), ElementsAre(6, 6, 6));
  EXPECT_THAT(styled("@layer b{.x{width:6px}}@layer a{.y.x{width:7px}}@layer b{.x{width:8px}}"), ElementsAre(8, 7, 8));
  EXPECT_THAT(styled("@layer{.x{width:6px}}@layer{.x{width:7px}}"), ElementsAre(7, 7, 7));
  EXPECT_THAT(styled(".x{width:5px!important}@layer a{.x{width:6px!important}}@layer b{.x{width:7px!important}}"),
              ElementsAre(6, 6, 6));
  EXPECT_THAT(notes_of("<style>@layer a.b{rect{width:6px}}</style>" + kGroups),
              ElementsAre("SVG: 1 x rule of a style sheet that is not understood: not applied"));
}

TEST(SvgCss, PaintsAndPropertiesThatAreNotReadAreNamed) {
  // A colour of a kind that is not read is a colour none the less.
  const std::string colour = "<rect width=\"4\" height=\"4\" fill=\"none\" stroke=\"oklch(60% 0.2 30)\"/>";
  EXPECT_THAT(widths(colour), ElementsAre(4));
  EXPECT_THAT(notes_of(colour), ElementsAre("SVG: 1 x colour that cannot be read, of a shape or group: not applied"));
  EXPECT_THAT(notes_of("<g style=\"zoom:2\"><rect width=\"4\" height=\"4\"/></g>"),
              ElementsAre("SVG: 1 x property zoom: not applied"));
  EXPECT_THAT(notes_of("<rect width=\"4\" height=\"4\" stroke=\"red\" style=\"stroke-dasharray:calc(4px) 2\"/>"),
              ElementsAre("SVG: 1 x property stroke-dasharray that cannot be read: not applied"));
  EXPECT_THAT(widths("<rect width=\"4\" height=\"4\" fill=\"url(#no) none\"/><rect width=\"5\" height=\"5\"/>"),
              ElementsAre(5));
  EXPECT_THAT(widths("<linearGradient id=\"g\"/><rect width=\"4\" height=\"4\" fill=\"url(#g) none\"/>"),
              ElementsAre(4));
}

TEST(SvgCss, PathsMayBeProperties) {
  EXPECT_THAT(widths("<style>path{d:path('M0 0H9V9')}</style><path d=\"M0 0H5V5\"/>"), ElementsAre(9));
  EXPECT_THAT(widths("<path style='d: path(\"M0 0H9V9\")'/>"), ElementsAre(9));
  EXPECT_THAT(widths("<path style='d:none' d=\"M0 0H5V5\"/><path d=\"M0 0H4V4\"/>"), ElementsAre(4));
  std::string data = "M0 0";
  for (int i = 1; i <= 1'000; ++i) data += "L" + std::to_string(i) + " 0";
  EXPECT_THAT(widths("<path style=\"d:path('" + data + "')\"/>"), ElementsAre(1'000));
  EXPECT_THAT(notes_of("<path style='d:url(#p)' d=\"M0 0H5V5\"/><rect width=\"4\" height=\"4\"/>"),
              ElementsAre("SVG: 1 x path with an error in its data, cut up to it (the first at the property d, which "
                          "must be none or path(\"...\"))"));
}

TEST(SvgCss, WhatIsNotUnderstoodIsNamed) {
  const std::string rect = "<rect width=\"4\" height=\"4\"/>";
  for (const std::string css :
       {"g:has(rect){display:none}", ":is(g rect){display:none}", "rect:nth-child(1 of .x){display:none}",
        "@container (width > 1px){rect{fill:none}}", "@media (min-width:1px){rect{fill:none}}", "rect!{fill:none}"}) {
    EXPECT_THAT(notes_of("<style>" + css + "</style>" + rect),
                ElementsAre("SVG: 1 x rule of a style sheet that is not understood: not applied"))
        << css;
  }
  for (const std::string css : {"rect:hover{fill:none}", "rect::after{fill:none}", "@media print{rect{fill:none}}",
                                "@font-face{font-family:a}", "@media (prefers-color-scheme:dark){rect{fill:none}}"}) {
    EXPECT_THAT(notes_of("<style>" + css + "</style>" + rect), IsEmpty()) << css;
  }
  EXPECT_THAT(notes_of(rect + "<circle style=\"r:calc(1px + 2px)\"/>"),
              ElementsAre("SVG: 1 x length that cannot be read (the first: r=\"calc(1px + 2px)\"): not applied"));
}

}  // namespace
}  // namespace kerf::svg
