// Colours as CSS writes them.

#include "server/service/drawing/colour.h"

#include <gtest/gtest.h>

namespace kerf::drawing {
namespace {

TEST(DrawingColour, AllForms) {
  struct Case {
    const char* text;
    std::uint32_t rgb;
    double alpha;
  };
  for (const Case& item :
       {Case{"red", 0xff0000, 1}, Case{"RebeccaPurple", 0x663399, 1}, Case{"#00f", 0x0000ff, 1},
        Case{"#0F08", 0x00ff00, 136 / 255.0}, Case{"#12aBcD", 0x12abcd, 1}, Case{"#12abcd00", 0x12abcd, 0},
        Case{"rgb(1, 2, 3)", 0x010203, 1}, Case{"rgb(100% 0% 50%)", 0xff0080, 1}, Case{"rgba(1,2,3,.5)", 0x010203, 0.5},
        Case{"rgb(1 2 3 / 25%)", 0x010203, 0.25}, Case{"rgb(300,-5,0)", 0xff0000, 1},
        Case{"hsl(120,100%,50%)", 0x00ff00, 1}, Case{"hsl(-120deg 100% 50%)", 0x0000ff, 1},
        Case{"hsla(0.5turn,100%,25%,0)", 0x008080, 0}, Case{" Transparent ", 0, 0},
        Case{"hsl(0, 0%, 100%)", 0xffffff, 1}}) {
    const std::optional<Colour> colour = parse_colour(item.text);
    ASSERT_TRUE(colour) << item.text;
    EXPECT_EQ(colour->rgb, item.rgb) << item.text;
    EXPECT_NEAR(colour->alpha, item.alpha, 1e-12) << item.text;
  }
  for (const char* text : {"", "none", "currentColor", "#12", "#ggg", "rgb(1,2)", "rgb 1 2 3", "hsl()", "no colour"}) {
    EXPECT_FALSE(parse_colour(text)) << text;
  }
}

TEST(DrawingColour, Names) {
  EXPECT_EQ(name_of_colour(0xff0000), "red");
  EXPECT_EQ(name_of_colour(0x123456), "#123456");
  EXPECT_EQ(name_of_colour(0x0000ff), "blue");
}

}  // namespace
}  // namespace kerf::drawing
