#include "server/api/picture_colours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace kerf::api {
namespace {

using Rgb = std::array<double, 3>;  // 0..255

// Okabe and Ito, "Color universal design" (2008), without black: told apart by the colour-blind too. In an order in
// which neighbours, as the parts of one cut are, differ most.
constexpr std::array<Rgb, 7> kPieces = {{{0x00, 0x72, 0xb2},
                                         {0xe6, 0x9f, 0x00},
                                         {0x00, 0x9e, 0x73},
                                         {0xcc, 0x79, 0xa7},
                                         {0x56, 0xb4, 0xe9},
                                         {0xd5, 0x5e, 0x00},
                                         {0xf0, 0xe4, 0x42}}};
// Further rounds through it are mixed with white and with black.
struct Round {
  double towards = 0.0;
  double share = 0.0;
};
constexpr std::array<Round, 3> kRounds = {{{255.0, 0.0}, {255.0, 0.5}, {0.0, 0.4}}};
constexpr std::uint8_t kNoPiece = 0x9a;

// Six colours of viridis (S. van der Walt, N. Smith, 2015, CC0): lightness grows evenly, and the colour-blind read it,
// too.
constexpr std::array<Rgb, 6> kStrains = {{{0x44, 0x01, 0x54},
                                          {0x41, 0x44, 0x87},
                                          {0x2a, 0x78, 0x8e},
                                          {0x22, 0xa8, 0x84},
                                          {0x7a, 0xd1, 0x51},
                                          {0xfd, 0xe7, 0x25}}};
constexpr double kSmallestEnd = 1.0e-4;
constexpr double kShareBelow = 0.99;
constexpr double kShrinkBelow = 0.2;  // of the current end: then it is chosen anew

std::uint8_t byte_between(double from, double to, double share) {
  return static_cast<std::uint8_t>(std::lround(from + share * (to - from)));
}

// The next of 1, 2, 5, 10, 20, ... times a power of ten that is not below `value`.
double rounded_up(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * decade * (1.0 + 1.0e-9)) return step * decade;
  }
  return 10.0 * decade;
}

}  // namespace

std::vector<std::uint8_t> piece_colours(const sheet::Topology& topology) {
  std::vector<std::uint8_t> colours(3 * topology.vertex_versions.size(), kNoPiece);
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) {
    if (topology.pieces[slot] == mesh::kNone) continue;
    const auto piece = static_cast<std::size_t>(topology.pieces[slot]);
    const Rgb& colour = kPieces[piece % kPieces.size()];
    const Round& round = kRounds[piece / kPieces.size() % kRounds.size()];
    for (const mesh::VertexId vertex : topology.triangles[slot]) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        colours[3 * static_cast<std::size_t>(vertex) + channel] =
            byte_between(colour[channel], round.towards, round.share);
      }
    }
  }
  return colours;
}

double strain_scale_end(std::span<const float> strains, double current) {
  std::vector<float> sorted;
  std::copy_if(strains.begin(), strains.end(), std::back_inserter(sorted),
               [](float each) { return std::isfinite(each); });
  double largest = kSmallestEnd;
  if (!sorted.empty()) {
    const auto rank = static_cast<std::ptrdiff_t>(std::floor(kShareBelow * (static_cast<double>(sorted.size()) - 1.0)));
    std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
    largest = std::max(largest, static_cast<double>(sorted[static_cast<std::size_t>(rank)]));
  }
  const bool fits = largest <= current && largest >= kShrinkBelow * current;
  return fits ? current : rounded_up(largest);
}

std::vector<std::uint8_t> strain_colours(std::span<const float> strains, double end) {
  constexpr auto kLast = static_cast<double>(kStrains.size() - 1);
  std::vector<std::uint8_t> colours;
  colours.reserve(3 * strains.size());
  for (const float strain : strains) {
    const double share = std::isfinite(strain) ? static_cast<double>(strain) / end : 0.0;
    const double at = kLast * std::clamp(share, 0.0, 1.0);
    const auto from = static_cast<std::size_t>(std::min(std::floor(at), kLast - 1.0));
    for (std::size_t channel = 0; channel < 3; ++channel) {
      colours.push_back(
          byte_between(kStrains[from][channel], kStrains[from + 1][channel], at - static_cast<double>(from)));
    }
  }
  return colours;
}

}  // namespace kerf::api
