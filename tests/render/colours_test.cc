#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include "render/colours.h"
#include "tests/render/colour_distance.h"
#include "tests/support/paths.h"

namespace kerf::render {
namespace {

using testing::as_seen_without;
using testing::Cone;
using testing::distance_of;
using testing::lab;

std::string text_of(const std::string& path) {
  std::ifstream in(test::source_path(path));
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// The colours in the brackets after `name` of a source file of the viewer.
std::vector<Rgb8> colours_in(const std::string& path, const std::string& name) {
  const std::string text = text_of(path);
  std::smatch list;
  EXPECT_TRUE(std::regex_search(text, list, std::regex(name + R"( = \[([^\]]*)\])"))) << name << " in " << path;
  const std::string inside = list[1];
  const std::regex hex("0x([0-9a-f]{6})");
  std::vector<Rgb8> colours;
  for (std::sregex_iterator at(inside.begin(), inside.end(), hex); at != std::sregex_iterator(); ++at) {
    const unsigned long value = std::stoul((*at)[1], nullptr, 16);
    colours.push_back({static_cast<std::uint8_t>(value >> 16U), static_cast<std::uint8_t>((value >> 8U) & 0xffU),
                       static_cast<std::uint8_t>(value & 0xffU)});
  }
  return colours;
}

TEST(StrainColours, AreTheViewersAtItsStops) {
  const std::vector<Rgb8> stops = colours_in("web/src/scene/strain_colors.ts", "kStops");
  ASSERT_EQ(stops.size(), 9U);
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const double share = 2.0 * static_cast<double>(i) / static_cast<double>(stops.size() - 1) - 1.0;
    // The table's nearest entry is within a two-thousandth of the scale.
    EXPECT_LT(distance_of(strain_colour(share), stops[i]), 0.5) << "stop " << i;
  }
}

TEST(StrainColours, AreGreyInTheMiddleAndDifferMoreTheFartherFromItForEveryEye) {
  const Rgb8 middle = strain_colour(0.0);
  EXPECT_EQ(middle[0], middle[1]);
  EXPECT_EQ(middle[1], middle[2]);
  for (const Cone missing : {Cone::kNone, Cone::kLong, Cone::kMiddle}) {
    const auto seen = [&](double share) { return as_seen_without(missing, strain_colour(share)); };
    for (const double side : {-1.0, 1.0}) {
      double before = 0.0;
      for (int i = 1; i <= 10; ++i) {
        const double difference = distance_of(seen(side * i / 10.0), seen(0.0));
        EXPECT_GT(difference, before + 2.3) << side * i / 10.0 << " without cone " << static_cast<int>(missing);
        before = difference;
      }
    }
  }
}

TEST(StrainColours, TellStretchFromCompressionForEveryEye) {
  for (const Cone missing : {Cone::kNone, Cone::kLong, Cone::kMiddle}) {
    for (int i = 1; i <= 10; ++i) {
      for (int k = 1; k <= 10; ++k) {
        const double difference = distance_of(as_seen_without(missing, strain_colour(i / 10.0)),
                                              as_seen_without(missing, strain_colour(-k / 10.0)));
        EXPECT_GT(difference, 10.0) << i / 10.0 << " and " << -k / 10.0 << " without cone "
                                    << static_cast<int>(missing);
      }
    }
  }
}

TEST(StrainColours, StayAtTheEndsBeyondThem) {
  EXPECT_EQ(strain_colour(-3.0), strain_colour(-1.0));
  EXPECT_EQ(strain_colour(1.7), strain_colour(1.0));
  EXPECT_EQ(strain_colour(std::nan("")), strain_colour(0.0));
  const std::vector<float> strains{0.0F, 0.01F, 0.02F, 5.0F, -0.01F};
  const std::vector<std::uint8_t> colours = strain_colours(strains, 0.02);
  ASSERT_EQ(colours.size(), 15U);
  for (std::size_t v = 0; v < strains.size(); ++v) {
    const Rgb8 expected = strain_colour(static_cast<double>(strains[v]) / 0.02);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(colours[3 * v + k], expected[k]) << "vertex " << v;
  }
}

TEST(StrainScale, EndsAtARoundNumberAboveMostStrains) {
  std::vector<float> strains(1000, 0.013F);
  EXPECT_DOUBLE_EQ(strain_scale_end(strains), 0.02);
  std::fill_n(strains.begin(), 9, 3.0F);  // at a pin
  EXPECT_DOUBLE_EQ(strain_scale_end(strains), 0.02);
  std::fill_n(strains.begin(), 50, 3.0F);
  EXPECT_DOUBLE_EQ(strain_scale_end(strains), 5.0);
  EXPECT_DOUBLE_EQ(strain_scale_end(std::vector<float>(10, -0.013F)), 0.02) << "compression counts as stretch does";
  EXPECT_DOUBLE_EQ(strain_scale_end(std::vector<float>(10, 0.0F)), 1e-4);
  EXPECT_DOUBLE_EQ(strain_scale_end({}), 1e-4);
  EXPECT_DOUBLE_EQ(strain_scale_end(std::vector<float>{NAN, 0.0199F, INFINITY}), 0.02);
  EXPECT_NEAR(strain_scale_end(std::vector<float>(10, 0.0499F)), 0.05, 1e-9) << "not 0.1";
}

TEST(StrainScale, StaysWhileItFits) {
  const std::vector<float> strains(100, 0.013F);
  EXPECT_DOUBLE_EQ(strain_scale_end(strains, 0.05), 0.05);
  EXPECT_DOUBLE_EQ(strain_scale_end(strains, 0.01), 0.02) << "too short";
  EXPECT_DOUBLE_EQ(strain_scale_end(strains, 0.1), 0.02) << "too long";
}

TEST(PieceColours, AreTheViewersForTheSameIds) {
  const std::vector<Rgb8> palette = colours_in("web/src/scene/piece_colors.ts", "kPalette");
  ASSERT_EQ(palette.size(), 7U);
  for (std::size_t i = 0; i < palette.size(); ++i) {
    EXPECT_EQ(piece_colour(static_cast<std::int64_t>(i) + 1), palette[i]) << "id " << i + 1;
    EXPECT_EQ(piece_colour(static_cast<std::int64_t>(i) + 22), palette[i]) << "the fourth round is the first again";
  }
  // Half way to white and two fifths of the way to black, in linear light.
  EXPECT_EQ(piece_colour(8), (Rgb8{188, 201, 221}));
  EXPECT_EQ(piece_colour(15), (Rgb8{0, 89, 141}));
}

TEST(PieceColours, AreToldApartByEveryEye) {
  for (const Cone missing : {Cone::kNone, Cone::kLong, Cone::kMiddle}) {
    for (std::int64_t a = 1; a <= 7; ++a) {
      for (std::int64_t b = a + 1; b <= 7; ++b) {
        EXPECT_GT(distance_of(as_seen_without(missing, piece_colour(a)), as_seen_without(missing, piece_colour(b))),
                  missing == Cone::kNone ? 25.0 : 12.0)
            << a << " and " << b << " without cone " << static_cast<int>(missing);
      }
    }
  }
  for (std::int64_t a = 1; a <= 21; ++a) {
    for (std::int64_t b = a + 1; b <= 21; ++b) {
      EXPECT_GT(distance_of(piece_colour(a), piece_colour(b)), 8.0) << a << " and " << b;
    }
  }
}

}  // namespace
}  // namespace kerf::render
