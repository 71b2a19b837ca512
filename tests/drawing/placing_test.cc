// Choosing parts of a drawing, and its size and place.

#include "server/service/drawing/placing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/cut/fit.h"
#include "server/service/drawing/arc_length.h"
#include "server/service/svg/svg.h"

namespace kerf::drawing {
namespace {

using Eigen::Vector2d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kField = "cut.curve.svg";

std::string page(const std::string& content,
                 const std::string& size = R"svg(width="210mm" height="297mm" viewBox="0 0 210 297")svg") {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size + ">" + content + "</svg>";
}

Result<Placed> placed(const std::string& text, const Reading& reading) {
  KERF_TRY(validate(reading, std::string(kField) + ".reading"));
  KERF_TRY_ASSIGN(const Drawing drawing, svg::read(text, {reading.unit, true}));
  return place(drawing, reading, "SVG", kField);
}

void expect_box(const Result<Placed>& done, const Vector2d& low, const Vector2d& high) {
  ASSERT_TRUE(done.ok()) << done.error().message;
  const cut::Box box = cut::extent(done->path);
  EXPECT_LT((box.low - low).norm() + (box.high - high).norm(), 1e-12)
      << box.low.transpose() << ", " << box.high.transpose();
}

const std::string kSquare = R"svg(<rect x="10" y="17" width="100" height="100"/>)svg";

TEST(DrawingPlacing, NamesTheShapeThatIsTooLarge) {
  const Result<Placed> done = placed(page(kSquare + R"svg(<path id="far" d="M0 0L1e30 0"/>)svg"), {});
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().reason, "CURVE_OUT_OF_RANGE");
  EXPECT_EQ(done.error().field, kField);
  EXPECT_THAT(done.error().message, HasSubstr("path #far reaches beyond"));
}

TEST(DrawingPlacing, TrueSize) {
  Reading reading;
  reading.true_size = true;
  // 100 mm on a page of A4: the corner of the page is the origin.
  expect_box(placed(page(kSquare), reading), {0.01, 0.18}, {0.11, 0.28});
  reading.at = Vector2d(0.5, -0.2);
  expect_box(placed(page(kSquare), reading), {0.51, -0.02}, {0.61, 0.08});
  reading.at.reset();
  // Units of the page: a pixel is 1/96 inch, and a unit of the view box fills what it is shown in.
  expect_box(placed(page(kSquare, R"svg(width="192" height="297")svg"), reading), Vector2d(10, 180) * 0.0254 / 96,
             Vector2d(110, 280) * 0.0254 / 96);
  expect_box(placed(page(kSquare, R"svg(width="20cm" viewBox="0 0 200 400")svg"), reading), {0.01, 0.283},
             {0.11, 0.383});
  expect_box(placed(page(kSquare, R"svg(width="40cm" height="40cm" viewBox="0 0 200 400")svg"), reading), {0.11, 0.283},
             {0.21, 0.383});
  expect_box(
      placed(page(kSquare, R"svg(width="40cm" height="40cm" viewBox="0 0 200 400" preserveAspectRatio="xMinYMid")svg"),
             reading),
      {0.01, 0.283}, {0.11, 0.383});
  // Without a page the corner of what is cut is the origin.
  expect_box(placed(page(kSquare, ""), reading), {0, 0}, Vector2d(100, 100) * 0.0254 / 96);
  reading.unit = 1e-3;
  expect_box(placed(page(kSquare, ""), reading), {0, 0}, {0.1, 0.1});
  expect_box(placed(page(kSquare, R"svg(viewBox="0 0 200 400")svg"), reading), {0.01, 0.283}, {0.11, 0.383});
  expect_box(placed(page(kSquare, R"svg(width="9in" height="18in" viewBox="0 0 200 400")svg"), reading), {0.01, 0.283},
             {0.11, 0.383});
}

TEST(DrawingPlacing, FitPage) {
  Reading reading;
  reading.fit_page = true;
  Result<Placed> done = placed(page(kSquare), reading);
  ASSERT_TRUE(done.ok());
  cut::Curve curve = done->path;
  ASSERT_TRUE(cut::fit_into({{0, 0}, {2.1, 2.97}}, curve).ok());
  const cut::Box all = cut::extent(curve);
  EXPECT_LT((all.low - Vector2d(0, 0)).norm() + (all.high - Vector2d(2.1, 2.97)).norm(), 1e-12);
  EXPECT_LT((std::get<cut::Path>(curve).subpaths[2].start - Vector2d(0.1, 2.8)).norm(), 1e-12);
  EXPECT_EQ(placed(page(kSquare, ""), reading).error().reason, "PAGE_MISSING");
  // Lines beyond the page do not count.
  done = placed(page(R"svg(<path d="M-300 0H900"/>)svg"), reading);
  EXPECT_NEAR(cut::frame(done->path).high.x(), 0.21, 1e-12);
}

TEST(DrawingPlacing, Selectors) {
  const std::string text = page(
      R"svg(<g id="Cut_Lines" class="outer"><path class="a b" d="M0 0H1" stroke="red"/></g>
            <g id="x"><path id="p" d="M0 0H2" stroke="#00f" fill="none"/><path d="M0 0H4" fill="rgb(0,128,0)"/></g>
            <path d="M0 0H8" display="none" stroke="yellow"/>)svg");
  const auto lengths = [&text](const std::vector<std::string>& only, bool all = false) {
    Reading reading;
    reading.only = only;
    reading.all_shapes = all;
    std::vector<int> found;
    const Result<Placed> done = placed(text, reading);
    if (!done.ok()) return found;
    for (const cut::Subpath& line : done->path.subpaths) {
      found.push_back(static_cast<int>(1e3 * length_of(line) + 0.5));
    }
    return found;
  };
  EXPECT_THAT(lengths({"stroke=red"}), ElementsAre(1));
  EXPECT_THAT(lengths({"stroke=#f00"}), ElementsAre(1));
  EXPECT_THAT(lengths({"stroke=hsl(240,100%,50%)"}), ElementsAre(2));
  EXPECT_THAT(lengths({"fill=green"}), ElementsAre(4));
  EXPECT_THAT(lengths({".a"}), ElementsAre(1));
  EXPECT_THAT(lengths({".outer"}), ElementsAre(1));
  EXPECT_THAT(lengths({"#x"}), ElementsAre(2, 4));
  EXPECT_THAT(lengths({"#p", ".b"}), ElementsAre(1, 2));
  EXPECT_THAT(lengths({"layer=x"}), ElementsAre(2, 4));
  EXPECT_THAT(lengths({"layer=Cut Lines"}), ElementsAre(1));
  EXPECT_THAT(lengths({"layer=Cut_Lines"}), ElementsAre(1));
  EXPECT_THAT(lengths({"stroke=yellow"}, true), ElementsAre(8));
  EXPECT_TRUE(lengths({"stroke=yellow"}).empty());
  const auto refusal = [&text](const std::vector<std::string>& only) {
    Reading reading;
    reading.only = only;
    return placed(text, reading).error();
  };
  EXPECT_EQ(refusal({"stroke=yellow"}).reason, "SVG_EMPTY");
  EXPECT_EQ(refusal({".a", "stroke=pink"}).reason, "SELECTOR_UNMATCHED");
  EXPECT_EQ(refusal({".a", "stroke=pink"}).field, "cut.curve.svg.reading.only[1]");
  EXPECT_THAT(refusal({"stroke=pink"}).message,
              HasSubstr("#Cut_Lines, #p, #x, .a, .b, .outer, fill=black, fill=green"));
  for (const char* wrong : {"", "red", "stroke=", "stroke=rose-ish", "layer=", ".", "#", "colour=red"}) {
    EXPECT_EQ(refusal({wrong}).reason, "SELECTOR_MALFORMED") << wrong;
  }
  EXPECT_EQ(refusal(std::vector<std::string>(65, ".a")).reason, "TOO_MANY");
}

TEST(DrawingPlacing, InkscapeLayers) {
  const std::string text =
      R"svg(<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape">
      <g inkscape:groupmode="layer" inkscape:label="Cut 1" id="layer1"><path d="M0 0H1"/>
      <g inkscape:groupmode="layer" inkscape:label="Inner"><path d="M0 0H2"/></g></g><g id="g5"><path d="M0 0H4"/></g></svg>)svg";
  Reading reading;
  reading.only = {"layer=Cut 1"};
  EXPECT_EQ(placed(text, reading)->path.subpaths.size(), 2U);
  reading.only = {"layer=Inner"};
  EXPECT_EQ(placed(text, reading)->path.subpaths.size(), 1U);
  reading.only = {"layer=g5"};
  EXPECT_EQ(placed(text, reading).error().reason, "SELECTOR_UNMATCHED");
}

TEST(DrawingPlacing, OptionsThatConflict) {
  Reading reading;
  reading.at = Vector2d(0, 0);
  EXPECT_EQ(placed(page(kSquare), reading).error().field, "cut.curve.svg.reading.at");
  reading.true_size = true;
  reading.fit_page = true;
  EXPECT_EQ(placed(page(kSquare), reading).error().reason, "OPTIONS_CONFLICT");
  reading = {};
  reading.unit = 1e4;
  EXPECT_EQ(placed(page(kSquare), reading).error().reason, "UNIT_OUT_OF_RANGE");
}

}  // namespace
}  // namespace kerf::drawing
