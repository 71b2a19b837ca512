// Looks of materials in pictures: by the nearest preset, and different for each.

#include "server/service/picture/material_look.h"

#include <array>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

namespace kerf::picture {
namespace {

using Channels = std::tuple<double, double, double>;

render::Look look_of(double modulus, double thickness, double density) {
  return look_of(LookNumbers{modulus, thickness, density});
}

Channels channels(const render::Colour& colour) {
  return {colour.red, colour.green, colour.blue};
}

TEST(MaterialLook, DiffersForEachPreset) {
  constexpr std::array<LookNumbers, 9> kPresets{{{4.0e5, 5.0e-4, 400},
                                                 {3.1e9, 5.0e-4, 1300},
                                                 {4.0e7, 4.0e-4, 375},
                                                 {5.938e6, 1.066e-3, 304},
                                                 {8.0e7, 1.2e-4, 420},
                                                 {1.5e6, 1.0e-3, 950},
                                                 {5.5e9, 1.0e-4, 800},
                                                 {5.0e5, 1.5e-3, 1100},
                                                 {6.9e10, 1.6e-5, 2710}}};
  std::set<Channels> fronts;
  for (const LookNumbers& preset : kPresets) {
    fronts.insert(channels(look_of(preset.modulus, preset.thickness, preset.density).front));
  }
  EXPECT_EQ(fronts.size(), kPresets.size());
}

TEST(MaterialLook, StaysWhileTheNumbersChangeALittle) {
  const render::Look silk = look_of(8.0e7, 1.2e-4, 420);
  const render::Look stiffer = look_of(1.6e8, 1.0e-4, 400);
  EXPECT_EQ(channels(stiffer.front), channels(silk.front));
  EXPECT_EQ(stiffer.finish.roughness, silk.finish.roughness);
  EXPECT_NE(channels(look_of(5.5e9, 1.0e-4, 800).front), channels(silk.front));
}

TEST(MaterialLook, HasTheFinishOfThePreset) {
  EXPECT_EQ(look_of(1.5e5, 5.0e-4, 400).finish.pattern, render::Pattern::kGingham);
  EXPECT_EQ(look_of(5.938e6, 1.066e-3, 304).finish.pattern, render::Pattern::kTwill);
  EXPECT_EQ(look_of(3.1e9, 5.0e-4, 1300).finish.pattern, render::Pattern::kKnit);
  EXPECT_GT(look_of(6.9e10, 1.6e-5, 2710).finish.mirror, 0.5);
}

}  // namespace
}  // namespace kerf::picture
